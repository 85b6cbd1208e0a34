"""The course of a search: effects enter one by one or as a pair; earlier ones are pruned, simplified, exchanged."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from discrepancy.effects.spec import Ranges
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.choice import Contender
from discrepancy.search.context import Context
from discrepancy.search.exchange import exchange
from discrepancy.search.fine import on_fine
from discrepancy.search.greedy import OVERWHELMING, Round, run_round
from discrepancy.search.noise import measure_noise, residual_parts, waves_left
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import Step
from discrepancy.search.pairs import find_pair
from discrepancy.search.prune import prune
from discrepancy.search.rough import settle_rough
from discrepancy.search.state import State, refit, with_best_forms, with_best_smoothing
from discrepancy.search.waves import with_best_waves


@dataclass(frozen=True, slots=True, kw_only=True)
class Course:
    """How far a search has come.

    Attributes:
        problem: with white noise weights.
        context: what it needs besides; `closed` is what the steps have closed.
        ranges: sizes of the signals.
        steps: accepted models, base first.
        rounds: as they were run.
    """

    problem: SimulationProblem
    context: Context
    ranges: Ranges
    steps: tuple[Step, ...]
    rounds: tuple[Round, ...] = ()

    @property
    def current(self) -> State:
        """The model so far."""
        return self.steps[-1].state


def add_effects(course: Course, options: SearchOptions) -> Course:
    """Return the course followed to its end: effects are added while one helps significantly and materially."""
    course = _resolved(course)
    # Adding and pruning could follow each other for ever: the number of rounds is bounded too.
    while len(course.current.added) < options.most_effects and len(course.rounds) < 2 * options.most_effects:
        course, taken = _next_round(course, options)
        if taken:
            course = _accepted(course, taken)
        else:
            # With a better law in the place of one that was taken early, further effects may show.
            exchanged = _exchanged(course, options) if options.exchanges else None
            if exchanged is None:
                return course
            course = exchanged
        found = course.current, list(course.steps)
        limits = options, course.context, course.context.closed
        _, steps = prune(course.problem, found, course.ranges, limits)
        course = _resolved(replace(course, steps=tuple(steps)))
    return course


def without_play(begun: Course, course: Course, options: SearchOptions) -> Course:
    """Return the course with a soft shaft in the place of play, where that leads much nearer.

    A free run with play is chaotic: beside it only large effects show. Where the round that took it saw a soft shaft
    come near, the search goes on from there as well, as though there were no play.

    Args:
        begun: the course at its beginning.
        course: the same at its end.
        options: decision limits.
    """
    chosen = next((done for done in course.rounds if _chose_play(done)), None)
    rival = None if chosen is None else _near_rival(chosen)
    if chosen is None or rival is None or not course.current.is_chaotic:
        return course
    play = frozenset(name for name, effect in EFFECTS.items() if effect.chaotic)
    # With play the steps went over to finer samples: here they are fitted to those of the beginning again.
    earlier = [
        replace(step, state=refit(begun.problem, step.state, begun.ranges, 3))
        for step in course.steps
        if step.added is None or step.added in chosen.start.added
    ]
    closed = np.sqrt(sum((step.closed**2 for step in earlier), np.zeros(1)))
    other = replace(
        begun,
        context=replace(begun.context, closed=closed, excluded=begun.context.excluded | play),
        steps=tuple(earlier),
        rounds=course.rounds[: course.rounds.index(chosen) + 1],
    )
    other = add_effects(_accepted(other, [replace(chosen, winner=rival, equivalents=())]), options)
    fine, *_ = on_fine(begun.problem, begun.context, (), begun.ranges)
    left = [refit(fine, one.current, one.ranges, 2).fit.loss - fine.rows for one in (other, course)]
    nearer = left[0] < OVERWHELMING * left[1]
    return (
        replace(other, context=replace(other.context, excluded=begun.context.excluded)) if nearer else course
    )


def _resolved(course: Course) -> Course:
    """Return the course in samples fine enough for its model."""
    if not course.current.is_chaotic:
        return course
    problem, context, steps = on_fine(course.problem, course.context, course.steps, course.ranges)
    return replace(course, problem=problem, context=context, steps=steps)


def _chose_play(done: Round) -> bool:
    return done.winner is not None and EFFECTS[done.winner.name].chaotic


def _near_rival(done: Round) -> Contender | None:
    """Return the simpler law that leaves not much more than the play that was chosen; None if there is none."""
    winner, rows = done.winner, done.problem.rows
    if winner is None:
        return None
    simpler = EFFECTS[winner.name].contains
    near = (winner.white_loss - rows) / OVERWHELMING + rows
    return next((c for c in done.contenders if c.name in simpler and c.white_loss < near), None)


def _next_round(course: Course, options: SearchOptions) -> tuple[Course, list[Round]]:
    """Return the course with one more round (a pair makes two), and those rounds of it that chose an effect."""
    problem, context = course.problem, course.context
    ranges = replace(course.ranges, waves=waves_left(problem, course.current))
    done = run_round(problem, course.current, ranges, options, context)
    start = done.start
    pair = () if done.winner else find_pair(problem, start, (ranges, options, context), done)
    more = pair or (done,)
    steps = (*course.steps[:-1], replace(course.steps[-1], state=start))
    course = replace(course, ranges=ranges, steps=steps, rounds=(*course.rounds, *more))
    return course, [one for one in more if one.winner is not None]


def _exchanged(course: Course, options: SearchOptions) -> Course | None:
    """Return the course with one effect exchanged for a better one; None if none was."""
    found = course.current, course.steps
    limits = options, course.context
    swapped = exchange(course.problem, found, course.ranges, limits, course.rounds)
    if swapped is None:
        return None
    _, steps, done = swapped
    return replace(course, steps=tuple(steps), rounds=(*course.rounds, done))


def _accepted(course: Course, taken: Sequence[Round]) -> Course:
    """Return the course with what its last rounds have chosen."""
    for done in taken:
        step = _accept((course.context.fine or course.problem, course.problem), done, course.ranges)
        # A richer law takes the place of the simpler one that it contains.
        kept = (one for one in course.steps if one.added is None or one.added in step.state.added)
        context = replace(course.context, closed=np.hypot(course.context.closed, step.closed))
        course = replace(course, context=context, steps=(*kept, step))
    return _quieter(course) if course.context.pairs else course


def _accept(problems: tuple[SimulationProblem, SimulationProblem], done: Round, ranges: Ranges) -> Step:
    """Return the step of a round's winner, its model fitted again; `problems`: fine and usual samples."""
    winner = done.winner
    if winner is None:
        raise ValueError("a round without a winner adds nothing")
    fine, problem = problems
    if winner.state.is_chaotic:
        # What finer samples have shown stays: a fit to the coarse ones would make up for their steps.
        current = refit(problem, settle_rough(fine, winner.state, ranges), ranges, 0)
    else:
        current = with_best_forms(problem, refit(problem, winner.state, ranges, 3), ranges)
        current = with_best_waves(problem, with_best_smoothing(problem, current), ranges)
    return Step(
        state=current, added=winner.name, equivalents=done.equivalents, fall=winner.fall, closed=winner.closed
    )


def _quieter(course: Course) -> Course:
    """Read the noise off the repeats again, beside the better model."""
    problem, context = course.problem, course.context
    noise, repeat = measure_noise(problem, residual_parts(problem, course.current), context.pairs)
    scout, fine = (
        None if one is None else replace(one, noise=noise) for one in (context.scout, context.fine)
    )
    context = replace(context, repeat_noise=repeat, scout=scout, fine=fine)
    return replace(course, problem=replace(problem, noise=noise), context=context)
