"""The whole search: rounds until nothing helps, then whether the names explain it all."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from discrepancy.effects.spec import Port, Ranges
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.locate import Place, locate
from discrepancy.search.at_ends import ends_decide
from discrepancy.search.bench import make_bench
from discrepancy.search.beside import locate_beside
from discrepancy.search.context import Context
from discrepancy.search.course import Course, add_effects, without_play
from discrepancy.search.curves import judge_curves
from discrepancy.search.doubts import find_doubts, seen_again, significant_left
from discrepancy.search.faint import with_faint_effects
from discrepancy.search.greedy import closed_amount
from discrepancy.search.noise import residual_parts
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import SearchOutcome, Step
from discrepancy.search.patchwork import driver_id, patchwork, place_of
from discrepancy.search.remainder import find_remainder
from discrepancy.search.retell import retold
from discrepancy.search.state import (
    State,
    refit,
    without,
)
from discrepancy.search.swallowed import with_swallowed_offset

FloatArray = NDArray[np.float64]
SHAKEN = 0.15
"""A name is taken back if what nobody explains is more than this part of what it closed."""
STILL = 0.5
"""When a name is taken back, another goes with it that closes less than this part of what it closed beside it."""


def search(
    problem: SimulationProblem,
    state: State,
    ranges: Ranges,
    options: SearchOptions,
    context: Context,
    names: Mapping[str, str],
) -> SearchOutcome:
    """Add effects while one helps significantly and materially, and ask whether they explain it all."""
    begun = Course(problem=problem, context=context, ranges=ranges, steps=(Step(state=state, added=None),))
    course = without_play(begun, add_effects(begun, options), options)
    course = with_faint_effects(course, options, add_effects)
    problem, context, ranges = course.problem, course.context, course.ranges
    steps = retold(problem, course.steps, ranges, context)
    steps = with_swallowed_offset(problem, steps, ranges, (options, context))
    outcome = SearchOutcome(
        steps=steps, rounds=course.rounds, problem=problem, ranges=ranges,
        names=names, context=context,
    )  # fmt: skip
    if outcome.is_torque:
        return _conclude_torque(outcome, ranges, context, names)
    return _conclude(outcome, (ranges, options, context), names)


def _conclude(
    outcome: SearchOutcome, rest: tuple[Ranges, SearchOptions, Context], names: Mapping[str, str]
) -> SearchOutcome:
    """Ask whether the names explain it all; take doubtful ones back and say where the rest lies."""
    ranges, options, context = rest
    bench = make_bench(outcome.problem, outcome.steps[-1].state, ranges, context)
    curves = judge_curves(bench, names)
    patched = patchwork(outcome.steps, significant_left(bench, curves, options))
    doubts = find_doubts(bench, (ranges, options), names, curves)
    doubt = doubts[0] if doubts else None
    outcome = replace(outcome, at_ends=ends_decide(outcome.problem, outcome.steps, doubted=doubt is not None))
    if doubt is None and not patched:
        return outcome
    if len(outcome.steps) == 1:
        return replace(outcome, unknown=doubt)
    doubted = patched | (_shaken(outcome, doubts, (bench.excess, names)) if doubts else set())
    kept = without_steps(outcome, doubted, ranges)
    if doubted:
        # What is seen beside the nearest laws is only their error of form: without them the whole of it shows again.
        doubt = seen_again(
            judge_curves(make_bench(outcome.problem, kept[-1].state, ranges, context), names), doubts
        )
    return replace(outcome, steps=kept, unknown=doubt)


def _shaken(
    outcome: SearchOutcome, doubts: Sequence[Place], rest: tuple[FloatArray, Mapping[str, str]]
) -> set[str]:
    """Return the names that doubts take back: those over their variables, and those that explained little more."""
    left, names = rest
    places = {(one.port, driver_id(one, names)) for one in doubts}
    return {
        str(step.added)
        for step in outcome.steps[1:]
        if place_of(step) in places or not np.any(_stands_out(step, left))
    }


def _stands_out(step: Step, left: FloatArray) -> NDArray[np.bool_]:
    """Return in which outputs a step closed much more than what is left, shape (C,)."""
    return np.asarray((step.closed > SearchOptions().material_noise) & (left <= SHAKEN * step.closed))


def without_steps(
    outcome: SearchOutcome, doubted: frozenset[str] | set[str], ranges: Ranges
) -> tuple[Step, ...]:
    """Return the steps without doubted effects, fitted again, and without those that closed much beside them only."""
    problem, context = outcome.problem, outcome.context
    kept, gone = [outcome.steps[0]], set(doubted)
    for step in outcome.steps[1:]:
        if step.added in gone:
            continue
        state = refit(
            problem, without(step.state, [name for name in gone if name in step.state.added]), ranges, 8
        )
        closed = closed_amount(problem, context, (kept[-1].state, state))
        if gone and np.all(closed < STILL * step.closed):
            gone.add(str(step.added))
        else:
            kept.append(replace(step, state=state))
    return tuple(kept)


def _conclude_torque(
    outcome: SearchOutcome, ranges: Ranges, context: Context, names: Mapping[str, str]
) -> SearchOutcome:
    """Do the same for a torque balance, whose residual shows its driver without any simulation."""
    problem, first = outcome.problem, outcome.steps[0].state
    patched = patchwork(outcome.steps, np.full(1, np.inf))
    unknown = find_remainder(problem, first, outcome.steps[-1].state, context, names)
    if unknown is None and not patched:
        return outcome
    if len(outcome.steps) == 1:
        return _placed_beside(replace(outcome, unknown=unknown), names)
    places = locate(problem.series, residual_parts(problem, first), first.fit.vector, names)
    return _placed_beside(
        _withdraw(outcome, places[0] if places else unknown, (ranges, names, patched)), names
    )


def _placed_beside(outcome: SearchOutcome, names: Mapping[str, str]) -> SearchOutcome:
    """Return an outcome without names with its unknown where a curve beside the joint's parameters explains most."""
    if outcome.unknown is None or len(outcome.steps) > 1 or outcome.unknown.port is not Port.TORQUE:
        return outcome
    place = locate_beside(outcome.problem, outcome.steps[0].state, names)
    return replace(outcome, unknown=place) if place.share > outcome.unknown.share else outcome


def _withdraw(
    outcome: SearchOutcome, unknown: Place | None, rest: tuple[Ranges, Mapping[str, str], frozenset[str]]
) -> SearchOutcome:
    """Take back doubted names and those over the unknown's driver: they were the nearest laws, not the right one."""
    ranges, names, patched = rest
    if unknown is None:
        return outcome
    place = (unknown.port, driver_id(unknown, names))
    doubted = patched | {str(step.added) for step in outcome.steps[1:] if place_of(step) == place}
    kept = without_steps(outcome, doubted, ranges)
    state = kept[-1].state
    places = locate(outcome.problem.series, residual_parts(outcome.problem, state), state.fit.vector, names)
    same = [place for place in places if place.driver == unknown.driver and place.port == unknown.port]
    return replace(outcome, steps=kept, unknown=same[0] if same else unknown)
