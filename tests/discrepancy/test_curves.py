"""Curves beside a model: what the catalogue has no law for is located, whatever the nearest law."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from daq.recording.recording import Recording, recording_from_columns
from discrepancy.assemble import column_names
from discrepancy.data.series import read_series
from discrepancy.effects.spec import Port
from discrepancy.model.schema import JointModel
from discrepancy.prepare import Prepared, prepare_simulation
from discrepancy.search.bench import make_bench
from discrepancy.search.curves import judge_curves
from discrepancy.search.doubts import find_doubts
from discrepancy.search.greedy import closed_amount
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import SearchOutcome, Step
from discrepancy.search.state import polish, scan_effect
from tests.discrepancy.recorder import excite

Torque = Callable[[float, float, float, float], float]
"""Torque on the joint at current, speed, angle and time, N m; positive drives."""


def sticky(current: float, speed: float, angle: float, time: float) -> float:
    """Return the motor's torque less a dry friction that acts in one band of the angle only (smoothed at rest)."""
    return current - 0.15 * float(np.exp(-(((angle - 0.3) / 0.4) ** 2))) * float(np.tanh(speed / 0.01))


def detuned(current: float, speed: float, angle: float, time: float) -> float:
    """Return the torque of a motor whose constant drifts the more, and the other way, the higher the current is."""
    return current * (1.0 - 0.1 * time / 16.0 * (1.0 - 3.0 * current**2))


def record(torque: Torque, seed: int) -> Recording:
    """Integrate J = 0.5 kg m^2, B = 0.9 N m s/rad for 16 s by the mid-point rule and add white speed noise."""
    n, step = 8000, 2e-3
    current = excite(0, n, step)
    speed, angle = np.zeros(n), np.zeros(n)
    for k in range(n - 1):
        i, w = 0.5 * (current[k] + current[k + 1]), speed[k]
        half = w + 0.5 * step * (torque(i, w, angle[k], k * step) - 0.9 * w) / 0.5
        middle = angle[k] + 0.5 * step * w
        speed[k + 1] = w + step * (torque(i, half, middle, (k + 0.5) * step) - 0.9 * half) / 0.5
        angle[k + 1] = angle[k] + step * half
    noisy = speed + np.random.default_rng(seed).normal(0.0, 0.01, n)
    columns = {
        "time_s": np.arange(n) * step, "current_A": current, "speed_rad_s": noisy, "position_rad": angle,
    }  # fmt: skip
    return recording_from_columns(columns, sample_time_s=step)


def prepare(nameplate: JointModel, torque: Torque) -> Prepared:
    return prepare_simulation(
        nameplate, [read_series(record(torque, seed), nameplate, "train") for seed in (1, 2)], None
    )


def test_dry_friction_in_one_place_is_seen_over_the_angle(nameplate: JointModel) -> None:
    p = prepare(nameplate, sticky)
    first = judge_curves(make_bench(p.problem, p.state, p.ranges, p.context), column_names(nameplate))[0]
    assert (first.place.port, first.place.driver) == (Port.TORQUE, "position_rad")
    angle, level = max(first.place.shape, key=lambda point: point[1])
    assert angle == pytest.approx(0.3, abs=0.2)
    # A hat of knots a few tenths apart blunts the top of 0.15 N m.
    assert level == pytest.approx(0.14, abs=0.03)


def test_a_drift_that_depends_on_the_current_is_not_taken_for_one_of_the_torque_constant(
    nameplate: JointModel,
) -> None:
    p = prepare(nameplate, detuned)
    named = polish(p.problem, scan_effect(p.problem, p.state, "torque_constant_drift", p.ranges), p.ranges)
    context = replace(p.context, closed=closed_amount(p.problem, p.context, (p.state, named)))
    bench = make_bench(p.problem, named, p.ranges, context)
    names = column_names(nameplate)
    place = find_doubts(bench, (p.ranges, SearchOptions()), names, judge_curves(bench, names))[0]
    assert place.port is Port.TORQUE
    assert place.driver in {"time_s", "current_A"}


def test_each_port_and_driver_is_located_once(nameplate: JointModel) -> None:
    prepared = prepare(nameplate, sticky)
    outcome = SearchOutcome(
        steps=(Step(state=prepared.state, added=None),), rounds=(), problem=prepared.problem,
        ranges=prepared.ranges, context=prepared.context, names=column_names(nameplate),
    )  # fmt: skip
    places = outcome.places(prepared.state, outcome.bench(prepared.state))
    keys = [(place.port, place.driver) for place in places]
    assert (Port.TORQUE, "position_rad") in keys
    assert len(keys) == len(set(keys))
