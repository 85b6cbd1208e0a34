"""Play between motor and load, and a stop that a fit has put out of reach: fits that no slope leads to."""

from dataclasses import replace

import numpy as np

from discrepancy.data.series import SPEED, read_series
from discrepancy.fitting.levenberg import COARSE_DIFFERENCE
from discrepancy.fitting.problem import Noise, SimulationProblem
from discrepancy.model.schema import JointModel
from discrepancy.prepare import FINE_FACTOR, Prepared, fine_problem, prepare_simulation
from discrepancy.search.judge import farthest_move, held_out
from discrepancy.search.rough import polish_rough, scan_rough, settle_rough, smoothed
from discrepancy.search.state import State, refit, scan_effect, with_unseen_parts
from discrepancy.simulation import slots as s
from tests.discrepancy.recorder import make_recording

PLAY = {
    s.GAP: 0.2, s.LOAD_SHARE: 0.98, s.STIFFNESS: 200.0, s.DAMPING_RATIO: 0.3, s.LOAD_FRICTION_SHARE: 0.95,
    s.MAX_STEP: 5e-4,
}  # fmt: skip
STOPS = {s.STOP_HIGH: 0.6, s.STOP_LOW: -0.6, s.STOP_STIFFNESS: 3.0, s.STOP_DAMPING: 0.3, s.MAX_STEP: 2e-3}


def prepared(nameplate: JointModel, truth: dict[int, float]) -> Prepared:
    series = [read_series(make_recording(truth, seed), nameplate, f"train[{seed}]") for seed in (1, 2)]
    return prepare_simulation(nameplate, series, None)


def test_play_is_found_from_a_joint_that_recalibration_has_dragged_away(nameplate: JointModel) -> None:
    p = prepared(nameplate, PLAY)
    fine = p.context.fine or p.problem
    scanned = scan_rough(p.context.scout or p.problem, p.state, "backlash", p.ranges)
    found = settle_rough(fine, polish_rough((fine, p.problem), scanned, p.ranges), p.ranges).fit
    # A hollow of the loss with another number of bounces is a fifth of the gap away or more.
    assert abs(found.vector[s.GAP] / PLAY[s.GAP] - 1.0) < 0.1
    assert abs(found.vector[s.LOAD_SHARE] - PLAY[s.LOAD_SHARE]) < 0.005
    beside = refit(fine, p.state, p.ranges, 5).fit.loss
    assert found.loss < 0.1 * beside


def test_the_place_in_the_gap_where_a_record_begins_is_found(nameplate: JointModel) -> None:
    p = prepared(nameplate, PLAY)
    vector = p.problem.prepare(s.neutral_vector())
    for slot, value in ({s.INERTIA: 0.5, s.VISCOUS: 0.9, **PLAY}).items():
        vector[slot] = value
    one = replace(p.problem.series[0], starts=np.zeros((1, 2)))
    begun = np.array([[0.0, 0.0, -1.0]])
    problem = SimulationProblem(series=(one,), noise=Noise(sigma={"speed_rad_s": 0.01}))
    channel = replace(one.channels[0], values=problem.simulate(vector, (begun,))[0][SPEED])
    shown = replace(problem, series=(replace(one, channels=(channel,)),))
    np.testing.assert_array_equal(shown.with_best_twists(vector, shown.initial_starts())[0], begun)


def test_a_joint_without_play_keeps_its_starts() -> None:
    problem = SimulationProblem(series=(), noise=Noise(sigma={}))
    starts = (np.ones((3, 2)),)
    assert problem.with_best_twists(s.neutral_vector(), starts) is starts


def test_fine_samples_are_those_of_the_same_records(nameplate: JointModel) -> None:
    train = [read_series(make_recording({}, seed), nameplate, f"train[{seed}]") for seed in (1, 2)]
    p = prepare_simulation(nameplate, train, None)
    fine = fine_problem(p.problem, train, FINE_FACTOR * p.factor)
    assert [one.label for one in fine.series] == [one.label for one in p.problem.series]
    assert fine.series[0].step == p.problem.series[0].step


def test_smoothing_leaves_the_slow_motion(nameplate: JointModel) -> None:
    problem = prepared(nameplate, {}).problem
    before, after = (one.series[0].channels[0].values for one in (problem, smoothed(problem, 0.04)))
    assert np.std(np.diff(after)) < 0.5 * np.std(np.diff(before))
    assert abs(np.mean(after - before)) < 1e-3


def test_a_stop_out_of_reach_is_put_back(nameplate: JointModel) -> None:
    p = prepared(nameplate, STOPS)
    best: State = refit(p.problem, scan_effect(p.problem, p.state, "end_stop", p.ranges)[0], p.ranges)
    vector = best.fit.vector.copy()
    vector[s.STOP_HIGH] = p.ranges.high + 5.0 * (p.ranges.high - p.ranges.low)
    lost = refit(p.problem, replace(best, fit=replace(best.fit, vector=vector)), p.ranges, 2)
    assert lost.fit.loss > 2.0 * best.fit.loss
    found = with_unseen_parts(p.problem, lost, p.ranges).fit
    assert abs(found.vector[s.STOP_HIGH] - STOPS[s.STOP_HIGH]) < 0.01


def test_a_block_left_out_moves_a_fit_no_farther_than_its_hollow(nameplate: JointModel) -> None:
    p = prepared(nameplate, {s.COULOMB: 0.2})
    found = p.state.fit
    assert farthest_move(found) == np.inf
    played = found.vector.copy()
    played[s.GAP] = 0.1
    assert farthest_move(replace(found, vector=played)) == COARSE_DIFFERENCE
    np.testing.assert_allclose(held_out(p.problem, found, 0.0).loss, found.loss)
    assert held_out(p.problem, found).loss > found.loss
