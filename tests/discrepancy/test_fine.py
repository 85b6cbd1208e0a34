"""In finer samples the noise is the noise that it was, and what an effect closes is what it closed."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from discrepancy.data.series import read_series
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.model.schema import JointModel
from discrepancy.prepare import Prepared, prepare_simulation
from discrepancy.search.course import Course, add_effects
from discrepancy.search.fine import on_fine
from discrepancy.search.full_rate import refine_full_rate
from discrepancy.search.greedy import Round, Screened, closed_amount, fit_all, run_round
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import SearchOutcome, Step
from discrepancy.search.state import State, polish, scan_effect
from discrepancy.simulation import slots as s
from tests.discrepancy.recorder import make_recording


@pytest.fixture
def sticky(nameplate: JointModel, monkeypatch: pytest.MonkeyPatch) -> Prepared:
    """Return a joint with dry friction, recorded twice, eight samples in a bin."""
    monkeypatch.setattr("discrepancy.prepare.MOST_SAMPLES", 2000)
    series = [read_series(make_recording({s.COULOMB: 0.15}, seed), nameplate, str(seed)) for seed in (1, 2)]
    return prepare_simulation(nameplate, series, None)


def accepted(p: Prepared) -> list[Step]:
    """Return the base model and the one with its dry friction."""
    state = polish(p.problem, scan_effect(p.problem, p.state, "coulomb_friction", p.ranges), p.ranges)
    closed = closed_amount(p.problem, p.context, (p.state, state))
    return [Step(state=p.state, added=None), Step(state=state, added="coulomb_friction", closed=closed)]


def test_noise_and_closed_gap_are_the_same_in_finer_samples(sticky: Prepared) -> None:
    steps = accepted(sticky)
    fine, context, moved = on_fine(sticky.problem, sticky.context, steps, sticky.ranges)
    assert fine.series[0].step < 0.5 * sticky.problem.series[0].step
    assert moved[-1].state.fit.residual.size == fine.measured().size
    assert moved[-1].state.fit.loss / fine.rows == pytest.approx(1.0, abs=0.1)
    assert moved[-1].closed == pytest.approx(steps[-1].closed, rel=0.05)
    assert context.closed == pytest.approx(moved[-1].closed)


def test_the_search_goes_on_there(sticky: Prepared) -> None:
    fine, context, moved = on_fine(sticky.problem, sticky.context, accepted(sticky)[:1], sticky.ranges)
    assert context.scout is not None
    assert fine.series[0].step < context.scout.series[0].step
    done = run_round(fine, moved[-1].state, sticky.ranges, SearchOptions(), context)
    assert done.winner is not None
    assert done.winner.name == "coulomb_friction"


def test_nothing_changes_where_it_is_fine_already_or_cannot_be(sticky: Prepared) -> None:
    steps = accepted(sticky)
    fine, context, moved = on_fine(sticky.problem, sticky.context, steps, sticky.ranges)
    again = on_fine(fine, context, moved, sticky.ranges)
    assert again[0] is fine
    assert again[1] is context
    without = replace(sticky.context, fine=None)
    assert on_fine(sticky.problem, without, steps, sticky.ranges)[0] is sticky.problem


def test_the_noise_of_coloured_samples_grows_less_than_that_of_white_ones(sticky: Prepared) -> None:
    def wider(bin_size: float) -> float:
        context = replace(sticky.context, bin_size=np.full(1, bin_size))
        fine = on_fine(sticky.problem, context, [Step(state=sticky.state, added=None)], sticky.ranges)[0]
        name = fine.series[0].channels[0].name
        return float(fine.noise.sigma[name] / sticky.problem.noise.sigma[name])

    coarse = sticky.problem.series[0]
    in_a_bin = coarse.step / coarse.original_step
    fine_step = sticky.context.fine.series[0].step if sticky.context.fine else np.nan
    assert wider(in_a_bin) == pytest.approx(np.sqrt(coarse.step / fine_step), rel=1e-6)
    assert wider(1.0) == pytest.approx(1.0)


def test_beside_play_a_further_effect_counts_from_a_twentieth_and_a_doubt_from_a_fifth(
    sticky: Prepared,
) -> None:
    context = replace(sticky.context, closed=np.full(1, 100.0))
    options = SearchOptions()
    assert context.least_added(options, ("backlash",)) == pytest.approx(5.0)
    assert context.material(options, ("backlash",)) == pytest.approx(20.0)
    assert context.least_added(options, ()) == pytest.approx(context.material(options, ()))


def test_the_full_rate_is_reached_from_finer_samples_too(sticky: Prepared, nameplate: JointModel) -> None:
    train = [read_series(make_recording({s.COULOMB: 0.15}, seed), nameplate, str(seed)) for seed in (1, 2)]
    fine, context, moved = on_fine(sticky.problem, sticky.context, accepted(sticky), sticky.ranges)
    outcome = SearchOutcome(
        steps=moved, rounds=(), problem=fine, ranges=sticky.ranges, context=context, names={}
    )
    last = refine_full_rate(outcome, train).steps[-1].state
    level = next(p.slot for p in last.fit.parameters if p.owner == "coulomb_friction")
    assert last.fit.vector[level] == pytest.approx(0.15, rel=0.02)


def test_a_search_beside_play_is_made_there(sticky: Prepared, monkeypatch: pytest.MonkeyPatch) -> None:
    steps: list[float] = []

    def nothing(problem: SimulationProblem, state: State, *rest: object) -> Round:
        steps.append(problem.series[0].step)
        return Round(start=state, before=state, contenders=(), winner=None, equivalents=(), problem=problem)

    monkeypatch.setattr("discrepancy.search.course.run_round", nothing)
    monkeypatch.setattr("discrepancy.search.course.find_pair", lambda *_: ())
    for given in ((), ("backlash",)):
        base = Step(state=replace(sticky.state, given=given), added=None)
        course = Course(problem=sticky.problem, context=sticky.context, ranges=sticky.ranges, steps=(base,))
        add_effects(course, SearchOptions())
    assert steps[0] == sticky.problem.series[0].step
    assert steps[1] < 0.5 * steps[0]


@pytest.mark.parametrize(("given", "from_scout"), [((), True), (("backlash",), False)])
def test_beside_play_a_candidate_begins_at_the_numbers_of_the_model_so_far(
    sticky: Prepared, monkeypatch: pytest.MonkeyPatch, given: tuple[str, ...], from_scout: bool
) -> None:
    viscous: list[float] = []

    def polished(_: object, scanned: Sequence[State], ranges: object) -> State:
        viscous.append(float(scanned[0].fit.vector[s.VISCOUS]))
        return scanned[0]

    state = replace(sticky.state, given=given)
    scanned = scan_effect(sticky.problem, state, "coulomb_friction", sticky.ranges)[0]
    scanned.fit.vector[s.VISCOUS] = -1.0
    screened = Screened(scanned=[[scanned]], coarse=state, rows=sticky.problem.rows)
    monkeypatch.setattr("discrepancy.search.greedy.polish", polished)
    fit_all(sticky.problem, state, screened, (sticky.ranges, SearchOptions(), sticky.context))
    assert viscous == [-1.0 if from_scout else float(state.fit.vector[s.VISCOUS])]
