"""Make blind cases: `python -m benchmarks.blind.generate OUT EFFECT[+EFFECT...] SEED [STRENGTH]`.

Runs in a process of its own. The recordings go to OUT/case.npz, the answer to OUT/answer.json, which the scorer
opens after all
verdicts are written. Physics is the emulated controller's: the induction motor in dq equations under its current
control.
"""

import json
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from daq.speed.filters import speed_from_position_zero_phase
from mock_dsp.control.parameters import FastLoopParameters
from mock_dsp.physics.rig import EmulatedRig
from mock_dsp.scenario.effects import EFFECTS
from mock_dsp.scenario.schema import Effect, Scenario

FloatArray = NDArray[np.float64]

TICK_S = 4e-4
DURATION_S = 40.0
FLUX_S = 1.0
CURRENT_A = 2.0**-13
TURNS_RAD = 20.0 * np.pi
_SHAPE = (
    "phase",
    "time_constant_s",
    "harmonic",
    "cycles",
    "speed",
    "critical",
    "stiffness",
    "damping",
    "centre",
    "width",
)
_LIMITS = ("limit", "lower", "upper")


def draw_parameters(name: str, generator: np.random.Generator, strength: float) -> dict[str, float]:
    """Draw an effect's parameters; amplitudes are scaled by `strength`, shapes are not."""
    found = {}
    for parameter in EFFECTS[name].parameters:
        value = float(generator.uniform(*parameter.draw))
        if not parameter.name.startswith((*_SHAPE, *_LIMITS)) or name in (
            "current_loop_lag",
            "speed_filter_lag",
        ):
            neutral = 1.0 if "gain" in parameter.name else 0.0
            value = neutral + (value - neutral) * strength
        found[parameter.name] = float(np.clip(value, parameter.minimum, parameter.maximum))
    return found


def excitation(generator: np.random.Generator, kind: str) -> FloatArray:
    """Return a reference current: `rich` (sines and a random step sequence) or the paper's `sine`."""
    time = np.arange(round(DURATION_S / TICK_S)) * TICK_S
    fade = np.minimum(1.0, time / 0.5)
    if kind == "sine":
        return np.asarray(0.8 * np.sin(2 * np.pi * time / 10.0) * fade)
    frequencies = np.exp(generator.uniform(np.log(0.05), np.log(8.0), 9))
    phases = generator.uniform(0, 2 * np.pi, 9)
    wave = np.sin(2 * np.pi * np.outer(frequencies, time) + phases[:, None]).sum(axis=0)
    steps = np.repeat(generator.choice([-1.0, 1.0], size=round(DURATION_S / 0.2) + 1), round(0.2 / TICK_S))[
        : time.size
    ]
    return np.asarray(np.clip(0.22 * wave + 0.25 * steps, -1.4, 1.4) * fade)


def record(scenario: Scenario, reference: FloatArray) -> dict[str, FloatArray]:
    """Play a reference on the emulated rig and return SI columns."""
    rig = EmulatedRig.from_scenario(scenario)
    rig.set_parameters(FastLoopParameters(pwm_on=True, centring_on=True, current_limit_a=2.0))
    rig.run(np.zeros(round(FLUX_S / TICK_S)))
    trace = rig.run(reference)
    position = (trace.position_counts.astype(np.float64) - 32768.0) * TURNS_RAD / 65536.0
    return {
        "time_s": np.arange(trace.ticks_done, dtype=np.float64) * TICK_S,
        "current_ref_A": trace.current_ref_counts.astype(np.float64) * CURRENT_A,
        "current_A": trace.current_counts.astype(np.float64) * CURRENT_A,
        "position_rad": position,
        "speed_rad_s": speed_from_position_zero_phase(position, TICK_S),
    }


def main(out: Path, names: list[str], seed: int, strength: float) -> None:
    """Write one case and its answer."""
    generator = np.random.default_rng(seed)
    effects = tuple(Effect(id=name, parameters=draw_parameters(name, generator, strength)) for name in names)
    out.mkdir(parents=True, exist_ok=True)
    train, test = excitation(generator, "rich"), excitation(generator, "rich")
    columns = {}
    for label, reference in (("train0", train), ("train1", train), ("test0", test)):
        scenario = Scenario(name="blind", seed=int(generator.integers(2**40)), effects=effects, sealed=True)
        for name, values in record(scenario, reference).items():
            columns[f"{label}/{name}"] = values
    np.savez(out / "case.npz", **columns)  # type: ignore[arg-type]  # savez takes any array by keyword
    answer = {"seed": seed, "strength": strength, "effects": [effect.model_dump() for effect in effects]}
    (out / "answer.json").write_text(json.dumps(answer, indent=2), encoding="utf-8")


if __name__ == "__main__":
    hidden = [] if sys.argv[2] == "none" else sys.argv[2].split("+")
    main(Path(sys.argv[1]), hidden, int(sys.argv[3]), float(sys.argv[4]) if len(sys.argv) > 4 else 1.0)
