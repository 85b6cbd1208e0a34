"""A law's wave number that settled in the wrong hollow is found again, and one that a constant has stretched."""

from dataclasses import replace

import pytest

from discrepancy.data.series import read_series
from discrepancy.effects.table import EFFECTS
from discrepancy.model.schema import JointModel
from discrepancy.prepare import Prepared, prepare_simulation
from discrepancy.search.noise import waves_left
from discrepancy.search.state import polish, refit, scan_effect, starting_vectors
from discrepancy.search.waves import with_best_waves
from discrepancy.simulation import slots as s
from tests.discrepancy.recorder import make_recording

RIPPLE = {s.RIPPLE_SIN: 0.05, s.RIPPLE_WAVE: 4.1}
WEIGHT = {s.GRAVITY_SIN: 0.15, s.GRAVITY_COS: 0.05, s.GRAVITY_WAVE: 0.4}


def prepare(nameplate: JointModel, truth: dict[int, float]) -> Prepared:
    series = [read_series(make_recording(truth, seed), nameplate, str(seed)) for seed in (1, 2)]
    return prepare_simulation(nameplate, series, None)


def test_cogging_in_the_hollow_beside_the_right_one_finds_it(nameplate: JointModel) -> None:
    p = prepare(nameplate, RIPPLE)
    ranges = replace(p.ranges, waves=waves_left(p.problem, p.state))
    right = polish(p.problem, scan_effect(p.problem, p.state, "torque_ripple", ranges), ranges)
    assert right.fit.vector[s.RIPPLE_WAVE] == pytest.approx(4.1, abs=0.02)
    vector = right.fit.vector.copy()
    vector[s.RIPPLE_WAVE] = 25.0
    caught = refit(p.problem, replace(right, fit=replace(right.fit, vector=vector)), ranges)
    assert abs(caught.fit.vector[s.RIPPLE_WAVE] - 4.1) > 0.5, "the case must be one that a fit cannot leave"
    found = with_best_waves(p.problem, caught, ranges)
    assert found.fit.vector[s.RIPPLE_WAVE] == pytest.approx(4.1, abs=0.02)


@pytest.mark.parametrize(
    ("name", "waves"), [("load_torque_offset", {0.25, 0.5, 1.0}), ("coulomb_friction", set())]
)
def test_an_offset_beside_a_weight_is_tried_with_other_wave_numbers_of_it(
    nameplate: JointModel, name: str, waves: set[float]
) -> None:
    p = prepare(nameplate, WEIGHT)
    weight = polish(p.problem, scan_effect(p.problem, p.state, "gravity_unbalance", p.ranges), p.ranges)
    fitted = float(weight.fit.vector[s.GRAVITY_WAVE])
    vectors = starting_vectors(weight, weight, EFFECTS[name], p.ranges)
    assert {float(one[s.GRAVITY_WAVE]) for one in vectors} == {fitted} | waves
