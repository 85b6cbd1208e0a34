"""An effect that was taken while others were missing makes way for the one that is really there."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from daq.recording.recording import Recording
from discrepancy.data.series import TORQUE, read_series
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.levenberg import Fit, fit, glance
from discrepancy.fitting.parameters import FitParameter
from discrepancy.fitting.problem import SimulationProblem, Starts
from discrepancy.model.schema import JointModel
from discrepancy.prepare import prepare_simulation
from discrepancy.search import course
from discrepancy.search.choice import Contender
from discrepancy.search.course import Course, add_effects
from discrepancy.search.exchange import exchange
from discrepancy.search.greedy import Round, Screened
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import Step
from discrepancy.search.state import State, polish, scan_effect
from discrepancy.simulation import slots as s
from discrepancy.workflow import run_gap
from tests.discrepancy.recorder import make_recording

Recorder = Callable[[Mapping[int, float], int], Recording]
TAKEN = ("coulomb_friction", "viscous_friction_drift")
OFFERED = {*TAKEN, "torque_constant_drift", "load_torque_offset"}


@pytest.mark.parametrize(
    ("drift", "named"),
    [
        ({s.CONSTANT_DRIFT: -0.3, s.CONSTANT_DRIFT_TIME: 10.0}, "torque_constant_drift"),
        ({s.VISCOUS_DRIFT: 0.3, s.VISCOUS_DRIFT_TIME: 10.0}, "viscous_friction_drift"),
    ],
)
def test_a_taken_name_stays_only_if_nothing_in_its_place_is_better(
    nameplate: JointModel, record: Recorder, drift: Mapping[int, float], named: str
) -> None:
    train = [read_series(record({s.COULOMB: 0.15, **drift}, k), nameplate, str(k)) for k in (1, 2)]
    prepared = prepare_simulation(nameplate, train, None)
    problem, ranges, state = prepared.problem, prepared.ranges, prepared.state
    steps = [Step(state=state, added=None)]
    for name in TAKEN:
        state = polish(problem, scan_effect(problem, state, name, ranges), ranges)
        steps.append(Step(state=state, added=name))
    context = replace(prepared.context, excluded=frozenset(EFFECTS) - OFFERED)
    done = exchange(problem, (state, steps), ranges, (SearchOptions(), context))
    if done is None:
        assert named in TAKEN
        return
    better, newer, _ = done
    assert {step.added for step in newer[1:]} == set(better.added) == {"coulomb_friction", named}
    assert named not in TAKEN


def test_a_law_that_nothing_comes_near_costs_no_round(
    nameplate: JointModel, record: Recorder, monkeypatch: pytest.MonkeyPatch
) -> None:
    train = [
        read_series(record({s.COULOMB: 0.15, s.CONSTANT_DRIFT: -0.3}, k), nameplate, str(k)) for k in (1, 2)
    ]
    prepared = prepare_simulation(nameplate, train, None)
    problem, ranges, state = prepared.problem, prepared.ranges, prepared.state
    for name in ("coulomb_friction", "torque_constant_drift"):
        state = polish(problem, scan_effect(problem, state, name, ranges), ranges)
    offered = {*state.added, "transport_delay"}
    context = replace(prepared.context, excluded=frozenset(EFFECTS) - offered)
    rounds: list[State] = []

    def spy(problem: SimulationProblem, reduced: State, *rest: object) -> Round:
        rounds.append(reduced)
        raise AssertionError("a round was run")

    monkeypatch.setattr("discrepancy.search.exchange.run_round", spy)
    assert exchange(problem, (state, []), ranges, (SearchOptions(), context)) is None
    assert rounds == []


def test_what_an_earlier_fit_knows_of_the_first_parameters_is_not_simulated_again(
    nameplate: JointModel, record: Recorder, monkeypatch: pytest.MonkeyPatch
) -> None:
    train = [read_series(record({s.COULOMB: 0.15}, 1), nameplate, "1")]
    prepared = prepare_simulation(nameplate, train, None)
    problem, ranges = prepared.problem, prepared.ranges
    state = polish(problem, scan_effect(problem, prepared.state, "coulomb_friction", ranges), ranges)
    known: list[int] = []

    def spy(
        problem: SimulationProblem,
        parameters: Sequence[FitParameter],
        at: tuple[NDArray[np.float64], Starts],
        iterations: int,
        reuse: NDArray[np.float64],
    ) -> Fit:
        known.append(len(parameters) - reuse.shape[1])
        return glance(problem, parameters, at, iterations, reuse)

    monkeypatch.setattr("discrepancy.search.state.glance", spy)
    scan_effect(problem, state, "transport_delay", ranges)
    # Only the delay itself is new; a law that takes the place of a simpler one is new as a whole.
    assert set(known) == {1}
    known.clear()
    scan_effect(problem, state, "stribeck_friction", ranges)
    own = [p for p in EFFECTS["stribeck_friction"].parameters if p.free]
    assert set(known) == {len(own)}


def test_a_glance_ends_where_a_fit_of_as_many_steps_does(nameplate: JointModel, record: Recorder) -> None:
    train = [read_series(record({s.COULOMB: 0.15}, 1), nameplate, "1")]
    prepared = prepare_simulation(nameplate, train, None)
    problem, at = prepared.problem, prepared.state.fit
    vector = at.vector.copy()
    vector[s.VISCOUS] *= 3.0
    seen = glance(problem, at.parameters, (vector, at.starts), 2, None)
    whole = fit(problem, at.parameters, vector, at.starts, 2)
    assert seen.loss == whole.loss
    assert np.array_equal(seen.vector, whole.vector)
    assert np.array_equal(seen.starts[0], whole.starts[0])


def test_what_a_round_chose_beside_the_same_effects_does_not_compete_again(
    nameplate: JointModel, record: Recorder, monkeypatch: pytest.MonkeyPatch
) -> None:
    train = [read_series(record({s.COULOMB: 0.15}, 1), nameplate, "1")]
    prepared = prepare_simulation(nameplate, train, None)
    problem, ranges, first = prepared.problem, prepared.ranges, prepared.state
    state = replace(first, added=TAKEN)
    won = Contender(name=TAKEN[1], state=state, white_loss=1.0)
    done = Round(
        start=replace(first, added=TAKEN[:1]), before=first, contenders=(won,), winner=won, equivalents=(),
        problem=problem,
    )  # fmt: skip
    tried: list[tuple[str, ...]] = []

    def spy(problem: SimulationProblem, reduced: State, *rest: object) -> Screened:
        tried.append(reduced.added)
        name = next(one for one in TAKEN if one not in reduced.added)
        return Screened(
            scanned=[[replace(state, added=(*reduced.added, name))]], coarse=_worse(state), rows=1.0
        )

    monkeypatch.setattr("discrepancy.search.exchange.screen", spy)
    limits = SearchOptions(), prepared.context
    assert exchange(problem, (state, []), ranges, limits, [done]) is None
    assert tried == [TAKEN[1:]]
    elsewhere = replace(done, start=first)
    assert exchange(problem, (state, []), ranges, limits, [elsewhere]) is None
    assert tried[1:] == [TAKEN[1:], TAKEN[:1]]


@pytest.mark.parametrize(("equivalents", "is_taken"), [(("belt_compliance",), True), ((), False)])
def test_a_law_of_fewer_parameters_that_nothing_tells_apart_takes_the_place(
    nameplate: JointModel,
    record: Recorder,
    monkeypatch: pytest.MonkeyPatch,
    equivalents: tuple[str, ...],
    is_taken: bool,
) -> None:
    train = [read_series(record({s.CURRENT_LAG: 0.03}, 1), nameplate, "1")]
    p = prepare_simulation(nameplate, train, None)

    def beside_an_offset(name: str) -> State:
        state = p.state
        for one in ("load_torque_offset", name):
            state = scan_effect(p.problem, state, one, p.ranges)[0]
        return state

    belt, lag = beside_an_offset("belt_compliance"), beside_an_offset("current_loop_lag")
    won = Contender(name="current_loop_lag", state=lag, white_loss=lag.fit.loss)
    done = Round(
        start=p.state,
        before=p.state,
        contenders=(won,),
        winner=won,
        equivalents=equivalents,
        problem=p.problem,
    )
    tried = Screened(scanned=[[belt], [lag]], coarse=_worse(_worse(belt)), rows=1.0)
    monkeypatch.setattr("discrepancy.search.exchange.screen", lambda *_: tried)
    monkeypatch.setattr("discrepancy.search.exchange.run_round", lambda *_: done)
    monkeypatch.setattr("discrepancy.search.exchange._is_better", lambda *_: False)
    steps = [Step(state=p.state, added=None), Step(state=belt, added="belt_compliance")]
    found = exchange(p.problem, (belt, steps), p.ranges, (SearchOptions(), p.context))
    assert (found is not None) is is_taken
    if found is not None:
        assert found[0].added == lag.added
        assert found[1][-1].equivalents == equivalents


def _worse(state: State) -> State:
    return replace(state, fit=replace(state.fit, loss=2.0 * state.fit.loss + 1.0))


@pytest.mark.parametrize(("output", "exchanged"), [("speed_rad_s", True), ("position_rad", False)])
def test_names_that_may_follow_the_drift_of_a_position_are_not_exchanged(
    nameplate: JointModel, monkeypatch: pytest.MonkeyPatch, output: str, exchanged: bool
) -> None:
    asked: list[int] = []

    def count(problem: SimulationProblem, *rest: object) -> None:
        asked.append(problem.series[0].channels[0].row)

    monkeypatch.setattr(course, "exchange", count)
    run_gap(
        replace(nameplate, outputs=(output,)), [make_recording({}, 1)], [make_recording({}, 2, input_seed=5)]
    )
    # The torque balance of a position, the second opinion, may exchange as it likes.
    assert bool(set(asked) - {TORQUE}) is exchanged


def test_what_an_exchanged_effect_has_made_unnecessary_is_dropped(
    nameplate: JointModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    series = [read_series(make_recording({s.COULOMB: 0.15}, seed), nameplate, str(seed)) for seed in (1, 2)]
    p = prepare_simulation(nameplate, series, None)
    state, steps = p.state, [Step(state=p.state, added=None)]
    for name in ("load_torque_offset", "coulomb_friction"):
        state = polish(p.problem, scan_effect(p.problem, state, name, p.ranges), p.ranges)
        steps.append(Step(state=state, added=name, closed=np.ones(1)))
    nothing = Round(start=state, before=state, contenders=(), winner=None, equivalents=(), problem=p.problem)
    swaps = iter([(state, steps, nothing)])
    monkeypatch.setattr(course, "run_round", lambda _, start, *rest: replace(nothing, start=start))
    monkeypatch.setattr(course, "find_pair", lambda *_: ())
    monkeypatch.setattr(course, "exchange", lambda *_: next(swaps, None))
    begun = Course(problem=p.problem, context=p.context, ranges=p.ranges, steps=tuple(steps[:1]))
    found = add_effects(begun, SearchOptions())
    assert found.current.added == ("coulomb_friction",)
    assert [step.added for step in found.steps] == [None, "coulomb_friction"]
