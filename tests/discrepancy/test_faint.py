"""Small effects beside large ones stand where, together, they close nearly all that the large ones leave."""

from dataclasses import replace

import pytest

from discrepancy.search import faint as module
from discrepancy.search.course import Course
from discrepancy.search.faint import with_faint_effects
from discrepancy.search.greedy import Round
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import Step
from discrepancy.search.state import State

LARGE, SMALL = "belt_compliance", "viscous_friction_drift"
OPTIONS = SearchOptions()


@pytest.fixture
def course(begun: Course) -> Course:
    """Return a course whose last round added nothing to one large effect."""
    large = replace(begun.current, added=(LARGE,))
    done = Round(start=large, before=large, contenders=(), winner=None, equivalents=(), problem=begun.problem)
    assert begun.context.repeat_noise is not None
    return replace(begun, steps=(*begun.steps, Step(state=large, added=LARGE)), rounds=(done,))


@pytest.mark.parametrize(
    ("part", "further", "is_named"),
    [
        pytest.param(0.97, (SMALL,), True, id="nearly all"),
        pytest.param(0.90, (SMALL,), False, id="not nearly all"),
        pytest.param(0.97, (SMALL, "torque_ripple", "quadratic_drag"), False, id="too many"),
    ],
)
def test_small_effects_stand_where_they_close_nearly_all_that_is_left(
    course: Course, monkeypatch: pytest.MonkeyPatch, part: float, further: tuple[str, ...], is_named: bool
) -> None:
    asked: list[SearchOptions] = []
    shut: list[frozenset[str]] = []

    def follow(one: Course, options: SearchOptions) -> Course:
        asked.append(options)
        shut.append(one.context.excluded)
        state = replace(one.current, added=(LARGE, *further))
        return replace(one, steps=(*one.steps, Step(state=state, added=SMALL)))

    def closed(_: object, before: State, after: State) -> float:
        assert (before.added, after.added) == ((LARGE,), (LARGE, *further))
        return part

    monkeypatch.setattr(module, "choose", lambda *_: object())
    monkeypatch.setattr(module, "refit", lambda _, state, *rest: state)
    monkeypatch.setattr(module, "closed_part", closed)
    found = with_faint_effects(course, OPTIONS, follow)
    assert (found is not course) is is_named
    assert [one.form_error for one in asked] == [OPTIONS.faint_form_error]
    # Lags follow errors of timing; the belt that is named may still be chosen again in its own place.
    assert "transport_delay" in shut[0]
    assert not {LARGE, SMALL} & shut[0]
    assert found.context.excluded == course.context.excluded


def never(_: Course, __: SearchOptions) -> Course:
    raise AssertionError("nothing to follow")


def test_nothing_is_followed_where_no_small_effect_would_enter(
    course: Course, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "choose", lambda *_: None)
    assert with_faint_effects(course, OPTIONS, never) is course


def test_without_repeats_nobody_knows_what_nearly_all_is(
    course: Course, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "choose", lambda *_: object())
    blind = replace(course, context=replace(course.context, repeat_noise=None))
    assert with_faint_effects(blind, OPTIONS, never) is blind
