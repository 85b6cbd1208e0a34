"""Cases of the second truth: effect, parameters, excitation, sampling and noise drawn from a seed."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tests.discrepancy.truth.joint import Joint, Wave
from tests.discrepancy.truth.run import Trace, integrate, sample

FloatArray = NDArray[np.float64]
Draw = Callable[[float, float], float]
Table = dict[str, Callable[[], dict[str, float]]]


def _hidden(name: str, a: Draw, k: float) -> dict[str, float]:
    """Return an effect's parameters; `k` scales its strength. Signals: about 0.6 N m rms, 1.5 rad/s peak."""
    return (_friction(a, k) | _mechanics(a, k) | _electrics_and_sensors(a, k))[name]()


def _friction(a: Draw, k: float) -> Table:
    return {
        "coulomb_friction": lambda: {"level": k * a(0.12, 0.25)},
        "asymmetric_coulomb_friction": lambda: {"forward": k * a(0.16, 0.25), "backward": k * a(0.06, 0.12)},
        "asymmetric_viscous_friction": lambda: {"skew": k * a(0.12, 0.3)},
        "stribeck_friction": lambda: _stribeck(k * a(0.1, 0.2), a(1.5, 2.2), a(0.05, 0.25)),
        "quadratic_drag": lambda: {"c": k * a(0.12, 0.3)},
        "presliding_hysteresis": lambda: {"level": k * a(0.15, 0.3), "stiffness": k * a(1.5, 6.0)},
        "viscous_friction_drift": lambda: {"change": -k * a(0.25, 0.5), "time": a(5, 20)},
        "load_dependent_friction": lambda: {"mu": k * a(0.12, 0.3)},
        "cubic_drag": lambda: {"c": k * a(0.15, 0.3)},
        "eddy_brake": lambda: {"peak": k * a(0.15, 0.3), "speed": a(0.2, 0.5)},
    }


def _mechanics(a: Draw, k: float) -> Table:
    turn = 2 * math.pi
    return {
        "load_torque_offset": lambda: {"torque": k * a(0.06, 0.2)},
        "gravity_unbalance": lambda: {"torque": k * a(0.15, 0.3), "wave": 1.0, "phase": a(0, turn)},
        "torque_ripple": lambda: {
            "torque": k * a(0.15, 0.3),
            "wave": float(round(a(3.5, 8.4))),
            "phase": a(0, turn),
        },
        "backlash": lambda: {
            "gap": k * a(0.15, 0.3),
            "stiffness": a(400, 900),
            "damping": a(4, 8),
            "load_part": a(0.4, 0.7),
        },
        "belt_compliance": lambda: {
            "stiffness": a(20, 60) / k,
            "damping": a(0.1, 0.3),
            "load_part": a(0.4, 0.7),
        },
        "position_dependent_inertia": lambda: {"part": k * a(0.2, 0.4), "wave": 1.0, "phase": a(0, turn)},
        "end_stop": lambda: {"angle": a(0.5, 0.7), "stiffness": a(3, 8), "damping": a(0.1, 0.4)},
        "spring": lambda: {"k": k * a(0.2, 0.4)},
    }


def _electrics_and_sensors(a: Draw, k: float) -> Table:
    return {
        "torque_constant_drift": lambda: {"change": -k * a(0.12, 0.25), "time": a(5, 20)},
        "torque_saturation": lambda: {"limit": a(1.2, 1.8) / math.sqrt(k)},
        "transport_delay": lambda: {"delay": k * a(0.02, 0.05)},
        "current_loop_lag": lambda: {"time": k * a(0.02, 0.05)},
        "current_saturation": lambda: {"limit": a(0.8, 1.0) / (1.0 - 0.2 * (1 - k))},
        "inverter_dead_time": lambda: {"lost": k * a(0.08, 0.16)},
        "current_sensor_offset": lambda: {"offset": k * a(0.05, 0.15)},
        "current_sensor_gain": lambda: {"gain": 1.0 + k * a(0.1, 0.2)},
        "potentiometer_nonlinearity": lambda: {
            "part": k * a(0.08, 0.15),
            "wave": a(1.0, 3.0),
            "phase": a(0, 2 * math.pi),
        },
        "speed_filter_lag": lambda: {"time": k * a(0.02, 0.05)},
        "rectified_speed_sensor": lambda: {"on": 1.0},
    }


def _stribeck(level: float, ratio: float, speed: float) -> dict[str, float]:
    return {"level": level, "static": ratio * level, "speed": speed}


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One hidden case: columns of one or two training records and one test record.

    Attributes:
        clean_test: test speed without noise.
        test_wave: command of the test.
        how: what a sample means: `instant`, `mean` or `hold`.
    """

    hidden: tuple[str, ...]
    joint: Joint
    train: tuple[dict[str, FloatArray], ...]
    test: dict[str, FloatArray]
    clean_test: FloatArray
    test_wave: Wave
    how: str


def bare_test(case: Case) -> FloatArray:
    """Return the noise-free test speed that the nameplate's joint predicts of the recorded current.

    Without the hidden effects, and under the current as a wrong sensor shows it.
    """
    offset, gain = case.joint.has("current_sensor_offset"), case.joint.has("current_sensor_gain")

    def shown(t: float) -> float:
        return case.test_wave(t) * (gain["gain"] if gain else 1.0) + (offset["offset"] if offset else 0.0)

    step = float(case.test["time_s"][1])
    duration = step * (case.clean_test.size - 1)
    trace, _ = _trace(replace(case.joint, hidden={}), shown, duration, step, case.how)
    return sample(
        trace.sensed, round(step / float(trace.time_s[1])), "mean" if case.how == "mean" else "instant"
    )


def rich_wave(rng: np.random.Generator, duration_s: float) -> Wave:
    """Return a sum of sines and a slow random step sequence, amplitude about 1 A."""
    frequencies = np.exp(rng.uniform(np.log(0.05), np.log(8.0), 9))
    phases = rng.uniform(0, 2 * np.pi, 9)
    sizes = rng.uniform(0.5, 1.0, 9) / (1.0 + frequencies / 3.0)
    sizes *= 0.62 / np.sqrt(0.5 * np.sum(sizes**2))
    steps = rng.choice([-1.0, 1.0], size=int(duration_s / 0.25) + 4)

    def wave(t: float) -> float:
        k = min(max(int(t / 0.25), 0), steps.size - 1)
        return float(np.sum(sizes * np.sin(2 * np.pi * frequencies * t + phases))) + 0.3 * float(steps[k])

    return wave


def sine_wave(amplitude: float, period_s: float) -> Wave:
    """Return the paper's sine."""
    return lambda t: amplitude * math.sin(2 * math.pi * t / period_s)


def make_case(
    names: tuple[str, ...],
    seed: int,
    strength: float = 1.0,
    noise: float = 0.012,
    rich: bool = True,
    repeats: bool = True,
) -> Case:
    """Draw a case from a seed.

    Args:
        names: hidden effects.
        seed: of everything random.
        strength: scale of the effects.
        noise: rms of the speed noise, rad/s.
        rich: rich excitation for training, else a sine.
        repeats: the first training record is repeated.
    """
    rng = np.random.default_rng(seed)

    def draw(a: float, b: float) -> float:
        return float(rng.uniform(a, b))

    joint = Joint(
        inertia=0.4 * draw(0.8, 1.2), viscous=0.8 * draw(0.8, 1.2), constant=draw(0.9, 1.1),
        hidden={name: _hidden(name, draw, strength) for name in names},
    )  # fmt: skip
    duration = 30.0
    step = float(rng.choice([4e-4, 1e-3, 2e-3, 5e-3, 1e-2]))
    # A hold makes the integrator restart at every sample: it is drawn where it matters, at the coarse steps.
    how = str(rng.choice(["instant", "mean", "hold"] if step >= 5e-3 else ["instant", "mean"]))
    train_wave = rich_wave(rng, duration) if rich else sine_wave(1.2, 5.0)
    waves = [train_wave, train_wave] if repeats else [train_wave]
    waves.append(rich_wave(rng, duration))
    distinct = {id(wave): wave for wave in waves}
    traces = {key: _trace(joint, wave, duration, step, how) for key, wave in distinct.items()}
    records = [_measure(joint, *traces[id(wave)], rng, noise, step, how) for wave in waves]
    *train, test = records
    return Case(
        hidden=names, joint=joint, train=tuple(c for c, _ in train), test=test[0], clean_test=test[1],
        test_wave=waves[-1], how=how,
    )  # fmt: skip


def _trace(joint: Joint, wave: Wave, duration: float, step: float, how: str) -> tuple[Trace, FloatArray]:
    """Integrate; with `hold` the controller updates its command once a sample."""
    grid = min(step / 4.0, 1e-3)
    grid = step / round(step / grid)

    def held(t: float) -> float:
        return wave(math.floor(t / step + 1e-9) * step)

    used = held if how == "hold" else wave
    trace = integrate(joint, used, duration, grid)
    return trace, np.array([used(t) for t in trace.time_s])


def _measure(
    joint: Joint,
    trace: Trace,
    command: FloatArray,
    rng: np.random.Generator,
    noise: float,
    step: float,
    how: str,
) -> tuple[dict[str, FloatArray], FloatArray]:
    every = round(step / float(trace.time_s[1]))
    mode = "mean" if how == "mean" else "instant"
    speed = sample(trace.sensed, every, mode)
    current = sample(command, every, mode)
    offset, gain = joint.has("current_sensor_offset"), joint.has("current_sensor_gain")
    current = current * (gain["gain"] if gain else 1.0) + (offset["offset"] if offset else 0.0)
    n = speed.size
    angle = sample(trace.angle, every, mode)
    columns = {
        "time_s": np.arange(n, dtype=np.float64) * step,
        "current_A": current + rng.normal(0.0, 0.002, n),
        "speed_rad_s": speed + rng.normal(0.0, noise, n),
        "position_rad": angle + rng.normal(0.0, 1e-4, n),
    }
    return columns, speed
