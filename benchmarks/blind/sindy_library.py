"""The rival's library: static torque laws of speed, current, angle and time, integrated over short windows.

SINDy as a discrepancy model (K. Kaheman et al., 2019): what the linear joint leaves is a sparse sum of candidate laws.
The momentum balance J dw = (Kt i - B w - laws) dt is taken in its integral form (H. Schaeffer, S. G. McCalla, Phys.
Rev. E 96, 2017), which needs no derivative of the noisy speed. Every law carries the id that it stands for; `None` is a
law that no id has. Effects with memory, delay or a second mass have no static law: the rival cannot name them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.question import SPEED, Question

FloatArray = NDArray[np.float64]

STRIDE_S = 0.02
SIGN_SPEED = 0.02
"""The sign of the speed turns over this range, rad/s: about twice the noise."""
SIGN_CURRENT = 0.02
RIPPLES = np.geomspace(0.9, 7.0, 60)
BASE = ("torque_constant", "viscous_friction")


@dataclass(frozen=True, slots=True, kw_only=True)
class Term:
    """One column: the id it stands for, and its values, shape (n,)."""

    stands_for: str | None
    values: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Balance:
    """Momentum balances of all training records.

    Attributes:
        change: J times the change of speed over each window, N m s, shape (n,).
        base: columns of the linear joint, Kt and -B, shape (n, 2).
        columns: laws, N m s for a coefficient of one, shape (n, m).
        stands_for: id of each law.
    """

    change: FloatArray
    base: FloatArray
    columns: FloatArray
    stands_for: tuple[str | None, ...]


def balance(question: Question, window_s: float) -> Balance:
    """Return the momentum balances of a question's training records over windows of `window_s`."""
    inertia = float(question.model["parameters"]["inertia"]["value"])
    records = [record for label, record in question.records.items() if label.startswith("train")]
    base, ripple = _base(question, records), _ripple_wave(question, records, inertia)
    terms = [_laws(record, question, ripple) for record in records]
    parts = [_windows(len(record[SPEED]), question.step_s, window_s) for record in records]

    def integrate(values: FloatArray, part: tuple[NDArray[np.int64], NDArray[np.int64]]) -> FloatArray:
        total = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]))]) * question.step_s
        return np.asarray(total[part[1]] - total[part[0]])

    change = [inertia * (r[SPEED][b] - r[SPEED][a]) for r, (a, b) in zip(records, parts, strict=True)]
    return Balance(
        change=np.concatenate(change),
        base=np.concatenate(
            [np.stack([integrate(c, p) for c in one], axis=1) for one, p in zip(base, parts, strict=True)]
        ),
        columns=np.concatenate(
            [
                np.stack([integrate(t.values, p) for t in one], axis=1)
                for one, p in zip(terms, parts, strict=True)
            ]
        ),
        stands_for=tuple(term.stands_for for term in terms[0]),
    )


def _windows(n: int, step_s: float, window_s: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    length, stride = max(1, round(window_s / step_s)), max(1, round(STRIDE_S / step_s))
    first = np.arange(0, n - length, stride, dtype=np.int64)
    return first, first + length


def _base(
    question: Question, records: Sequence[Mapping[str, FloatArray]]
) -> list[tuple[FloatArray, FloatArray]]:
    name = question.model["input"]
    return [(record[name], -record[SPEED]) for record in records]


def _laws(record: Mapping[str, FloatArray], question: Question, ripple: float) -> list[Term]:
    speed, angle, current = record[SPEED], record["position_rad"], record[question.model["input"]]
    time = record["time_s"] / record["time_s"][-1]
    # As the linear joint expects it: a measured acceleration would share its noise with the balance's other side.
    nameplate = question.model["parameters"]
    constant, friction = (float(nameplate[name]["value"]) for name in BASE)
    rate = constant * current - friction * speed
    sign = np.tanh(speed / SIGN_SPEED)
    low, high = (float(np.quantile(angle, q)) for q in (0.1, 0.9))
    laws: list[tuple[str | None, FloatArray]] = [
        ("load_torque_offset", np.ones_like(speed)),
        ("coulomb_friction", sign),
        ("asymmetric_viscous_friction", np.abs(speed)),
        ("quadratic_drag", speed * np.abs(speed)),
        (None, speed**3),
        ("stribeck_friction", sign * np.exp(-((speed / 0.1) ** 2))),
        ("stribeck_friction", sign * np.exp(-((speed / 0.25) ** 2))),
        ("load_dependent_friction", sign * np.abs(current)),
        ("torque_saturation", current * np.abs(current)),
        ("torque_saturation", current**3),
        ("inverter_dead_time", np.tanh(current / SIGN_CURRENT)),
        ("transport_delay", np.gradient(current, question.step_s)),
        ("gravity_unbalance", np.sin(0.25 * angle)),
        ("gravity_unbalance", np.cos(0.25 * angle) - 1.0),
        ("torque_ripple", np.sin(ripple * angle)),
        ("torque_ripple", np.cos(ripple * angle)),
        ("position_dependent_inertia", rate * np.sin(0.25 * angle)),
        ("position_dependent_inertia", rate * np.cos(0.25 * angle)),
        ("end_stop", np.maximum(0.0, angle - high)),
        ("end_stop", np.minimum(0.0, angle - low)),
        ("viscous_friction_drift", time * speed),
        ("torque_constant_drift", time * current),
    ]
    return [Term(stands_for=name, values=values) for name, values in laws]


def _ripple_wave(question: Question, records: Sequence[Mapping[str, FloatArray]], inertia: float) -> float:
    """Return the wave number at which what the linear joint leaves repeats most over the angle."""
    record = records[0]
    current = record[question.model["input"]]
    every = max(1, round(STRIDE_S / question.step_s))
    rate = inertia * np.gradient(record[SPEED], question.step_s)
    columns = np.stack([rate, current, record[SPEED]], axis=1)[::every]
    angle = record["position_rad"][::every]
    fixed = columns[:, 1:]
    left = columns[:, 0] - fixed @ np.linalg.lstsq(fixed, columns[:, 0], rcond=None)[0]
    power = [abs(np.sum(left * np.exp(-1j * wave * angle))) for wave in RIPPLES]
    return float(RIPPLES[int(np.argmax(power))])
