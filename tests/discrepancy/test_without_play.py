"""Where play was taken though a soft shaft came near, the search is asked again without play."""

from dataclasses import replace

import pytest

from discrepancy.effects.spec import Ranges
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search import course as module
from discrepancy.search.choice import Contender
from discrepancy.search.course import Course, without_play
from discrepancy.search.fine import scout_problem
from discrepancy.search.greedy import Round
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import Step
from discrepancy.search.state import State, refit

PLAY, SHAFT = "backlash", "belt_compliance"
OPTIONS = SearchOptions()


def ended(begun: Course, shaft_leaves: float) -> Course:
    """Return the course that took play; a soft shaft left so many times as much."""
    start = begun.current
    rows = begun.problem.rows
    losses = {PLAY: 100.0 * rows, SHAFT: (1.0 + shaft_leaves * 99.0) * rows}
    contenders = tuple(
        Contender(name=name, state=replace(start, added=(name,)), white_loss=loss)
        for name, loss in losses.items()
    )
    done = Round(
        start=start, before=start, contenders=contenders, winner=contenders[0], equivalents=(),
        problem=begun.problem,
    )  # fmt: skip
    return replace(begun, steps=(*begun.steps, step_of(start, PLAY)), rounds=(done,))


def step_of(state: State, name: str) -> Step:
    return Step(state=replace(state, added=(name,)), added=name)


@pytest.mark.parametrize(
    ("shaft_leaves", "nearer", "named"),
    [
        pytest.param(1.8, True, SHAFT, id="a shaft and others explain it"),
        pytest.param(1.8, False, PLAY, id="they leave as much"),
        pytest.param(2.2, True, PLAY, id="the shaft was never near"),
    ],
)
def test_a_soft_shaft_and_further_effects_may_take_the_place_of_play(
    begun: Course, monkeypatch: pytest.MonkeyPatch, shaft_leaves: float, nearer: bool, named: str
) -> None:
    course = ended(begun, shaft_leaves)
    seen: list[Course] = []

    def follow(one: Course, _: SearchOptions) -> Course:
        seen.append(one)
        return one

    def fitted(_: object, state: State, *rest: object) -> State:
        loss = begun.problem.rows * (3.0 if PLAY not in state.added and nearer else 100.0)
        return replace(state, fit=replace(state.fit, loss=loss))

    monkeypatch.setattr(module, "add_effects", follow)
    monkeypatch.setattr(module, "_accept", lambda *args: step_of(begun.current, args[1].winner.name))
    monkeypatch.setattr(module, "refit", fitted)
    found = without_play(begun, course, OPTIONS)
    assert found.steps[-1].added == named
    assert found.context.excluded == begun.context.excluded
    # The other search does not meet play again.
    assert [PLAY in one.context.excluded for one in seen] == ([True] if shaft_leaves < 2.0 else [])


def test_nothing_is_asked_again_where_no_play_was_taken(begun: Course) -> None:
    assert without_play(begun, begun, OPTIONS) is begun


def test_what_was_named_before_play_is_fitted_to_the_samples_of_the_beginning_again(
    begun: Course, monkeypatch: pytest.MonkeyPatch
) -> None:
    course = ended(begun, 1.5)
    base = begun.steps[0]
    other = scout_problem(begun.problem)
    moved = replace(base, state=refit(other, base.state, begun.ranges, 0))
    assert moved.state.fit.residual.size < base.state.fit.residual.size

    def fitted(problem: SimulationProblem, state: State, ranges: Ranges, iterations: int) -> State:
        if not state.added:
            return refit(problem, state, ranges, iterations)
        loss = problem.rows * (100.0 if PLAY in state.added else 3.0)
        return replace(state, fit=replace(state.fit, loss=loss))

    monkeypatch.setattr(module, "add_effects", lambda one, _: one)
    monkeypatch.setattr(module, "_accept", lambda *args: step_of(begun.current, args[1].winner.name))
    monkeypatch.setattr(module, "refit", fitted)
    found = without_play(begun, replace(course, steps=(moved, course.steps[-1])), OPTIONS)
    assert [one.added for one in found.steps] == [None, SHAFT]
    assert found.steps[0].state.fit.residual.size == base.state.fit.residual.size
