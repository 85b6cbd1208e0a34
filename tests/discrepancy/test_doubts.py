"""The guard against confident wrong names: a named law that fails elsewhere, or is seen only in a limit."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from discrepancy.assemble import column_names
from discrepancy.data.series import read_series
from discrepancy.effects.spec import Port
from discrepancy.locate import Place
from discrepancy.model.schema import JointModel
from discrepancy.prepare import prepare_simulation
from discrepancy.search.bench import Judgement, make_bench
from discrepancy.search.curves import Curve, judge_curves
from discrepancy.search.doubts import find_doubts, pressed, seen_again, significant_left
from discrepancy.search.options import SearchOptions
from discrepancy.search.state import polish, scan_effect
from discrepancy.simulation import slots as s
from discrepancy.workflow import run_gap
from tests.discrepancy.recorder import make_recording

FRICTION = {s.COULOMB: 0.15}


def doubt(nameplate: JointModel, truth: Mapping[int, float], named: str) -> tuple[Place | None, list[str]]:
    """Fit one effect to a joint; return the doubt about it, and its parameters that are pressed against a bound."""
    records = [make_recording(truth, seed) for seed in (1, 2)]
    p = prepare_simulation(nameplate, [read_series(r, nameplate, "train") for r in records], None)
    state = polish(p.problem, scan_effect(p.problem, p.state, named, p.ranges), p.ranges)
    gained = (p.state.fit.loss - state.fit.loss) / state.fit.residual.size / p.context.bin_size
    context = replace(p.context, closed=np.sqrt(np.maximum(0.0, gained)))
    bench = make_bench(p.problem, state, p.ranges, context)
    names = column_names(nameplate)
    places = find_doubts(bench, (p.ranges, SearchOptions()), names, judge_curves(bench, names))
    return next(iter(places), None), [state.fit.parameters[i].name for i in pressed(state.fit, state.added)]


def test_the_right_law_is_not_doubted(nameplate: JointModel) -> None:
    assert doubt(nameplate, FRICTION, "coulomb_friction")[0] is None


def test_a_torque_over_the_angle_beside_a_named_friction_is_a_doubt(nameplate: JointModel) -> None:
    truth = {**FRICTION, s.GRAVITY_SIN: 0.1, s.GRAVITY_WAVE: 1.0}
    place, _ = doubt(nameplate, truth, "coulomb_friction")
    assert place is not None
    assert (place.port, place.driver) == (Port.TORQUE, "position_rad")


def curve(driver: str, share: float, fall: float = 100.0) -> Curve:
    place = Place(port=Port.TORQUE, driver=driver, region=None, share=share)
    return Curve(place=place, judged=Judgement(fall=fall, closed=np.array([share])), size=8)


@pytest.mark.parametrize(
    ("second", "fall", "expected"),
    [(0.76, 100.0, "position_rad"), (0.60, 100.0, "time_s"), (0.76, -1.0, "time_s")],
    ids=["about as much", "less", "does not predict"],
)
def test_of_places_that_show_about_as_much_the_one_that_was_doubted_stands(
    second: float, fall: float, expected: str
) -> None:
    shown = [curve("time_s", 0.8), curve("position_rad", second, fall)]
    doubts = [curve("speed_rad_s", 0.5).place, curve("position_rad", 0.4).place]
    place = seen_again(shown, doubts)
    assert place is not None
    assert (place.driver, place.share) == (expected, 0.8 if expected == "time_s" else second)
    assert seen_again(shown, []) == shown[0].place
    assert seen_again([], doubts) == doubts[0]


@pytest.mark.parametrize(
    ("named", "left", "is_doubted"),
    [
        pytest.param(0.15, 0.06, True, id="left is much of what was named"),
        pytest.param(0.15, 0.03, False, id="left is little of it"),
        pytest.param(5.0, 0.06, False, id="left is nothing beside it"),
    ],
)
def test_a_weak_name_is_doubted_where_a_curve_would_close_about_as_much(
    nameplate: JointModel, named: float, left: float, is_doubted: bool
) -> None:
    records = [make_recording(FRICTION, seed) for seed in (1, 2)]
    p = prepare_simulation(nameplate, [read_series(r, nameplate, "train") for r in records], None)
    state = polish(p.problem, scan_effect(p.problem, p.state, "coulomb_friction", p.ranges), p.ranges)
    context = replace(p.context, closed=np.array([named]), signal=np.array([20.0]))
    bench = make_bench(p.problem, state, p.ranges, context)
    left_over = [curve("time_s", left, fall=200.0)]
    places = find_doubts(bench, (p.ranges, SearchOptions()), column_names(nameplate), left_over)
    assert [one.driver for one in places] == (["time_s"] if is_doubted else [])


def test_only_significant_curves_count_as_left(nameplate: JointModel) -> None:
    records = [make_recording(FRICTION, seed) for seed in (1, 2)]
    p = prepare_simulation(nameplate, [read_series(r, nameplate, "train") for r in records], None)
    bench = make_bench(p.problem, p.state, p.ranges, p.context)
    curves = [curve("time_s", 0.3, fall=500.0), curve("speed_rad_s", 0.9, fall=50.0)]
    assert significant_left(bench, curves, SearchOptions()) == pytest.approx([0.3])
    assert significant_left(bench, [], SearchOptions()) == pytest.approx([0.0])


SPRING = {s.GRAVITY_SIN: 6.0, s.GRAVITY_WAVE: 0.05}
"""A sine of a hundred radians' period is a straight line over the travel: a spring of 0.3 N m/rad."""


def test_a_spring_presses_the_wave_number_of_gravity_to_its_limit(nameplate: JointModel) -> None:
    place, at_bound = doubt(nameplate, SPRING, "gravity_unbalance")
    assert place is not None
    assert at_bound == ["wave_number"]


def test_a_spring_is_not_named(nameplate: JointModel) -> None:
    records = [make_recording(SPRING, seed) for seed in (1, 2)]
    result = run_gap(nameplate, records, [make_recording(SPRING, 12)])
    assert result.verdict == "unknown"
    assert result.effects == ()
    assert result.unknown is not None
    assert (result.unknown.port, result.unknown.driver) == (Port.TORQUE, "position_rad")


STIFFNESS = 0.3


@pytest.mark.parametrize(("level", "is_doubted"), [(0.1, False), (1e3, True)])
def test_friction_that_was_never_overcome_is_a_spring(
    nameplate: JointModel, level: float, is_doubted: bool
) -> None:
    truth = {s.PRESLIDING_LEVEL: level, s.PRESLIDING_STIFFNESS: STIFFNESS, s.PRESLIDING_SHAPE: 3.0}
    place, _ = doubt(nameplate, truth, "presliding_hysteresis")
    assert (place is not None) is is_doubted
