"""One round of the search: fit every candidate, find the noise, judge on held-out blocks, choose."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from discrepancy.effects.spec import Ranges
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.choice import Contender, choose, equivalents_of, own_size
from discrepancy.search.context import Context
from discrepancy.search.judge import farthest_move, held_out
from discrepancy.search.noise import noise_beside
from discrepancy.search.options import SearchOptions
from discrepancy.search.outputs import output_losses, output_rows
from discrepancy.search.rough import polish_rough, scan_rough
from discrepancy.search.same import Equivalent
from discrepancy.search.state import SCAN_KEEP, State, polish, refit, refit_from, scan_effect, without

FloatArray = NDArray[np.float64]
A = TypeVar("A")
B = TypeVar("B")
FAR = 9.0
"""Candidates whose loss is this multiple of the best one's cannot win under any noise model."""
OVERWHELMING = 0.5
"""A law leads whatever its held-out loss if it leaves less than this part of what the one that would lead leaves."""
WORTH = 0.9
"""A law is a start for richer ones if it leaves less than this part of the squared error."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Round:
    """What one round found, best first; `start` is the model that it began from, fitted better where it found how."""

    start: State
    before: State
    contenders: tuple[Contender, ...]
    winner: Contender | None
    equivalents: tuple[Equivalent, ...]
    problem: SimulationProblem


@dataclass(frozen=True, slots=True, kw_only=True)
class Screened:
    """The best states of each candidate, best first, and the model so far, on the same coarse samples.

    Attributes:
        rows: expected sum of squares of pure noise on these samples.
    """

    scanned: Sequence[list[State]]
    coarse: State
    rows: float

    @property
    def floor(self) -> float:
        """Return the least loss that a candidate has reached."""
        return min(one[0].fit.loss for one in self.scanned)

    @property
    def limit(self) -> float:
        """Return the loss above which a candidate closes less than half of what the best one does."""
        return max(self.floor, self.rows) + 0.5 * max(0.0, self.coarse.fit.loss - self.floor)

    @property
    def in_reach(self) -> frozenset[str]:
        """Return the candidates below that limit."""
        return frozenset(one[0].added[-1] for one in self.scanned if one[0].fit.loss < self.limit)


def candidates_for(state: State, excluded: frozenset[str]) -> list[str]:
    """Return the effects that may still be added: not present, and not contained in one that is."""
    covered = set(state.present) | excluded
    for name in state.present:
        covered |= set(EFFECTS[name].contains)
    return [name for name in EFFECTS if name not in covered]


def fan_out(executor: Executor | None, function: Callable[[A], B], items: Sequence[A]) -> list[B]:
    """Apply `function` to all items, on the executor if there is one."""
    if executor is None:
        return [function(item) for item in items]
    return list(executor.map(function, items))


def run_round(
    problem: SimulationProblem,
    state: State,
    ranges: Ranges,
    options: SearchOptions,
    context: Context,
    screened: Screened | None = None,
) -> Round:
    """Fit every effect on top of `state` and choose.

    Args:
        problem: with white noise weights.
        state: the model so far.
        ranges: sizes of the signals.
        options: decision limits.
        context: executor, noise of repeats if known, samples per bin.
        screened: what `screen` returned for this state, if that is known.
    """
    tried = screened or screen(problem, state, ranges, context)
    contenders = fit_all(problem, state, tried, (ranges, options, context))
    best = contenders[0]
    # What a candidate's fit found for the parameters of the joint alone is no merit of the candidate.
    bare = refit(problem, without(best.state, [best.name]), ranges, 8)
    if best.state.added[:-1] == state.added and bare.fit.loss < state.fit.loss:
        state = replace(state, fit=bare.fit)
    while True:
        done = _judge(problem, state, contenders, (ranges, options, context))
        leader = next(c for c in done.contenders if c.name == contenders[0].name)
        # A law that fits what it has seen and fails on what it has not must not set the measure for the others.
        if done.winner is not None or leader.fall > -options.alarm or len(contenders) < 2:
            return done
        contenders = contenders[1:]


def _judge(
    problem: SimulationProblem,
    state: State,
    contenders: Sequence[Contender],
    rest: tuple[Ranges, SearchOptions, Context],
) -> Round:
    """Judge the best contenders on held-out blocks, in the noise that the best of them leaves (or repeats show)."""
    ranges, options, context = rest
    best = contenders[0]
    sharp = replace(problem, noise=noise_beside(problem, best.state, context.repeat_noise, context.pairs))
    finalists = [c for c in contenders[: options.finalists] if c.white_loss < FAR * best.white_loss]
    before = refit(sharp, state, ranges, 3)
    states = {c.name: c.state for c in finalists}
    again = fan_out(context.executor, partial(_again, sharp, states, ranges), list(states))
    unit = _noise_unit(sharp, before, again, known=context.repeat_noise is not None)
    reference = held_out(sharp, before.fit, farthest_move(before.fit)).loss / unit
    judged = []
    for contender, one in zip(finalists, again, strict=True):
        closed = closed_amount(problem, context, (state, contender.state))
        fall = reference - held_out(sharp, one.fit, farthest_move(one.fit)).loss / unit
        part = closed_part(problem, state, contender.state)
        judged.append(replace(contender, state=one, fall=float(fall), closed=closed, part=part))
    judged = _ranked(judged, problem.rows, options)
    winner = choose(judged, options, (state, context))
    others = () if winner is None else equivalents_of(winner, judged, options, context)
    return Round(
        start=state, before=before, contenders=tuple(judged), winner=winner, equivalents=others, problem=sharp
    )


def closed_part(problem: SimulationProblem, before: State, after: State) -> float:
    """Return the closed part of the gap (rms, 0 to 1) of the output of which the newer model closes most."""
    old, new = (output_losses(problem, state.fit.residual) for state in (before, after))
    rows = output_rows(problem)
    # A sum of squares of noise is itself uncertain: less than this is no gap at all.
    gap = np.maximum(old - rows, 0.05 * rows + 1e-300)
    return float(np.sqrt(np.max(np.clip((old - new) / gap, 0.0, 1.0))))


def closed_amount(problem: SimulationProblem, context: Context, pair: tuple[State, State]) -> FloatArray:
    """Return what the second model closes of the first one's gap, rms by output in units of one sample's noise."""
    before, after = (output_losses(problem, state.fit.residual) for state in pair)
    return context.rms(problem, before - after)


def _ranked(judged: Sequence[Contender], rows: float, options: SearchOptions) -> list[Contender]:
    """Order by the held-out loss; a candidate that leaves less than half of what the first of that order leaves leads.

    Leaving out blocks is computed by linearisation, which a chaotic motion defies; what leaves half the error with a
    handful of parameters needs no such proof.
    """
    ranked = sorted(judged, key=lambda c: options.per_parameter * c.size - c.fall)
    if len(ranked) < 2:
        return ranked
    best = min(ranked, key=lambda c: c.white_loss)
    least, leading = (max(0.0, c.white_loss - rows) for c in (best, ranked[0]))
    if least < OVERWHELMING * leading and best.fall > options.alarm + options.per_parameter * own_size(best):
        ranked.remove(best)
        ranked.insert(0, best)
    return ranked


def fit_all(
    problem: SimulationProblem,
    state: State,
    screened: Screened,
    rest: tuple[Ranges, SearchOptions, Context],
) -> list[Contender]:
    """Fit every candidate that could still win to the end on fine samples, best first.

    A candidate is left behind only where it closes less than half of what the best one does.
    """
    ranges, options, context = rest
    coarse, scout = screened.coarse, context.scout or problem
    ranked = sorted(screened.scanned, key=lambda one: one[0].fit.loss)
    keep = [one for i, one in enumerate(ranked) if one[0].fit.loss < screened.limit or i < options.finalists]
    # A rough law costs more than all others: where it gains no more than chance does, nobody needs it to the end.
    unit = 1.0 if context.repeat_noise is not None else max(1.0, screened.floor / scout.rows)
    keep = [
        one
        for one in keep
        if not EFFECTS[one[0].added[-1]].chaotic
        or _gain(one[0], coarse) > unit * _least_gain(one[0], options)
    ]
    if context.scout is not None:
        keep = [[_on_fine_samples(one, state) for one in few] for few in keep]
    done = fan_out(context.executor, partial(_polish, (context.fine or problem, problem), ranges), keep)
    contenders = [Contender(name=one.added[-1], state=one, white_loss=one.fit.loss) for one in done]
    return sorted(contenders, key=lambda c: c.white_loss + options.per_parameter * c.size)


def _on_fine_samples(scanned: State, state: State) -> State:
    """Return a scanned candidate with what coarse samples cannot know taken from the model so far.

    That is where each window starts; and beside play, whose hollows lie elsewhere in coarse samples, every number that
    both have.
    """
    vector = scanned.fit.vector.copy()
    if state.is_chaotic:
        for parameter in state.fit.parameters:
            if parameter in scanned.fit.parameters:
                vector[parameter.slot] = state.fit.vector[parameter.slot]
    return replace(scanned, fit=replace(scanned.fit, vector=vector, starts=state.fit.starts))


def screen(problem: SimulationProblem, state: State, ranges: Ranges, context: Context) -> Screened:
    """Try all starts of every candidate for a few steps on coarse samples."""
    coarse, scout = state, problem
    if context.scout is not None:
        scout = context.scout
        first = refit_from(scout, state, scout.initial_starts())
        coarse = replace(state, fit=first)
    names = candidates_for(state, context.excluded)
    scanned = fan_out(context.executor, partial(_scan, scout, coarse, ranges), names)
    scanned = _rescanned(scanned, partial(_scan_richer, scout, ranges), (context.executor, coarse))
    return Screened(scanned=scanned, coarse=coarse, rows=scout.rows)


def _gain(scanned: State, before: State) -> float:
    """Return by how much a scanned law lowers the loss."""
    return before.fit.loss - scanned.fit.loss


def _least_gain(scanned: State, options: SearchOptions) -> float:
    """Return what an effect has to gain in the end to be significant and material, in noise variances."""
    own = sum(1 for p in EFFECTS[scanned.added[-1]].parameters if p.free)
    visible = options.material_noise**2 * scanned.fit.residual.size
    return options.alarm + options.per_parameter * own + visible


def _rescanned(
    scanned: Sequence[list[State]],
    function: Callable[[tuple[State, str]], list[State]],
    rest: tuple[Executor | None, State],
) -> list[list[State]]:
    """Start laws that contain a simpler one from that one's fit too."""
    executor, state = rest
    by_name = {one[0].added[-1]: one for one in scanned}
    worth = {name for name, one in by_name.items() if one[0].fit.loss < WORTH * state.fit.loss}
    pairs = [(by_name[c][0], name) for name in by_name for c in EFFECTS[name].contains if c in worth]
    for (_, name), more in zip(pairs, fan_out(executor, function, pairs), strict=True):
        whole = [replace(one, added=(*state.added, name)) for one in more if one.added[:-1] == state.added]
        by_name[name] = sorted([*by_name[name], *whole], key=lambda one: one.fit.loss)[:SCAN_KEEP]
    return list(by_name.values())


def _scan_richer(problem: SimulationProblem, ranges: Ranges, pair: tuple[State, str]) -> list[State]:
    return _scan(problem, pair[0], ranges, pair[1])


def _scan(problem: SimulationProblem, state: State, ranges: Ranges, name: str) -> list[State]:
    scan = scan_rough if EFFECTS[name].chaotic else scan_effect
    return scan(problem, state, name, ranges)


def _polish(
    problems: tuple[SimulationProblem, SimulationProblem], ranges: Ranges, scanned: list[State]
) -> State:
    if EFFECTS[scanned[0].added[-1]].chaotic:
        return polish_rough(problems, scanned, ranges)
    return polish(problems[1], scanned, ranges)


def _again(problem: SimulationProblem, states: dict[str, State], ranges: Ranges, name: str) -> State:
    return refit(problem, states[name], ranges, 3)


def _noise_unit(problem: SimulationProblem, before: State, again: Sequence[State], *, known: bool) -> float:
    """Return the noise variance of a whitened sample: known from repeats, else what the best model leaves."""
    best = min(one.fit.loss for one in (before, *again)) / problem.rows
    return max(1.0, best) if known else best
