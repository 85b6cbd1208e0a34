"""Which record would show what the records so far could hide.

The answer `none` says that every effect is weaker than what would have been seen (`detectable.py`). Here each effect of
the catalogue is put into the joint at half that strength. The distance at which the fitted joint, refitted to the old
records and a new one, stays from what the joint with the effect does in all of them, is the expected gain in
log-likelihood of naming it; an effect is shown when it reaches what the search asks for. One simulation an effect gives
this for all lengths of a candidate (`information.py`).

The candidate that shows most effects per second is chosen; a record costs what it lasts and `OVERHEAD_S`. Effects that
no candidate shows do not count. A record like those that there are already shows little that they do not: where no
candidate shows `LEAST_SHOWN` of the effects, or the best one is worth less than `LEAST_WORTH`, the rig has said what it
can, and nothing is proposed.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from discrepancy.design.detectable import Hidden, Sight, hidden_effects, signal_of, smallest_seen
from discrepancy.design.excitations import RAMP_S, Candidate, candidate_excitations, variations
from discrepancy.design.information import Growth, growth_of, left_apart
from discrepancy.design.prediction import Stage, beside, blank_series, simulate, time_inside, with_outputs
from discrepancy.design.proposal import (
    ENOUGH,
    SCREEN_S,
    VARIED,
    Outlook,
    Proposal,
    durations,
    ranked,
)
from discrepancy.effects.spec import Ranges
from discrepancy.fitting.levenberg import start_projector
from discrepancy.fitting.problem import COARSE_STEP_ANGLE
from discrepancy.search.context import Context
from discrepancy.search.options import SearchOptions
from discrepancy.search.state import State

FloatArray = NDArray[np.float64]

FINER = 0.5
"""Effects are looked for at this part of the strength that would have been seen."""
LONGEST_S = 20.0
"""A longer record shows more of everything, and there is always one more: this is what a first look is worth."""
SHOWN = 0.8
"""An effect is listed if the strength from which it would show falls below this part of what it is now."""
LEAST_SHOWN = 0.25
"""Least part of the effects that a record must be expected to show."""
LEAST_WORTH = 0.1
"""Least part of the way to being named that a record must bring the effects, on average over the catalogue."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sought:
    """An effect at the strength at which it is looked for.

    Attributes:
        now: strength that would have been seen, in its unit; the first starting value where not even that would.
        size: the strength that is looked for.
        old: sums over the records so far.
        begun: part of what the search asks for that the records so far give.
    """

    hidden: Hidden
    now: float
    size: float
    old: Growth
    begun: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Revealed:
    """What a record would show of one effect: from `then` on instead of from `now` on, strengths in `unit`."""

    id: str
    parameter: str
    unit: str
    now: float
    then: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Discovery:
    """A chosen experiment and what it would show, most gained first."""

    proposal: Proposal
    reveals: tuple[Revealed, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """Where a discovery is made: the fitted joint, what it may hide, and the limits of naming it."""

    stage: Stage
    state: State
    sight: Sight
    sought: tuple[Sought, ...]
    options: SearchOptions


def search_of(
    stage: Stage, state: State, rest: tuple[Ranges, SearchOptions, Context], excluded: Collection[str] = ()
) -> Search:
    """Return every effect that the joint may hide, at the strength at which it is looked for.

    Args:
        stage: where predictions are made; its known records are those so far.
        state: the fitted joint.
        rest: sizes of the signals, limits of the search, and what it knew of noise and size of each output.
        excluded: effects that these records cannot show by their making.
    """
    ranges, options, context = rest
    sight = Sight(stage.problem(*stage.known), state, context)
    linear = any(c.name.endswith(("_m", "_m_s", "force")) for c in stage.template.channels)
    found = []
    for one in hidden_effects(state, ranges, linear=linear):
        if one.id in excluded:
            continue
        seen = smallest_seen(sight, one, options)
        now = one.full if seen is None else seen
        old = sight.sums(one.at(FINER * now))
        begun = min(0.99, sight.shown(one, FINER * now, options))
        found.append(Sought(hidden=one, now=now, size=FINER * now, old=old, begun=begun))
    return Search(stage=stage, state=state, sight=sight, sought=tuple(found), options=options)


def discover(search: Search) -> Discovery | None:
    """Return the record that shows most for its time, None if the limits allow none that shows enough."""
    if not search.sought:
        return None
    stage = replace(search.stage, step_angle=COARSE_STEP_ANGLE)
    outlooks = _looked(search, stage, candidate_excitations(stage.limits))
    if not outlooks:
        return None
    best = np.max([one.shares.max(axis=0) for one in outlooks], axis=0)
    items = best >= ENOUGH
    if np.mean(items) < LEAST_SHOWN:
        return None
    leaders = [one for one, _ in ranked(outlooks, items)[:VARIED]]
    more = [near for one in leaders for near in variations(one.candidate, stage.limits)]
    for outlook, k in ranked([*outlooks, *_looked(search, stage, more)], items):
        length = float(outlook.lengths[k])
        if stage.limits.allows({**outlook.candidate.excitation, "ramp_s": RAMP_S}, length):
            found = _discovery(search, outlook, k)
            return found if found.proposal.worth >= LEAST_WORTH else None
    return None


def _looked(search: Search, stage: Stage, candidates: Sequence[Candidate]) -> list[Outlook]:
    found = [_look(search, stage, one) for one in candidates]
    return [one for one in found if one is not None]


def _look(search: Search, stage: Stage, candidate: Candidate) -> Outlook | None:
    """Return how much of the way to being named each effect comes, for every length inside the limits."""
    lengths = [one for one in durations(stage) if one <= LONGEST_S] or durations(stage)[:1]
    length = min(SCREEN_S, lengths[-1])
    blank = blank_series(stage, candidate.excitation, length)
    outputs = simulate(stage, blank, search.state)
    inside = time_inside(outputs, blank.step, stage.limits)
    if inside < lengths[0] - blank.step:
        return None
    longest = lengths[-1] if inside >= length - blank.step else inside
    kept = np.array([one for one in lengths if one <= longest + blank.step])
    filled = with_outputs(blank, outputs, in_windows=search.state.is_chaotic)
    problem, done = stage.problem(filled), beside(stage, filled, search.state)
    projector = start_projector(problem, done)
    base = problem.flatten(problem.simulate(problem.prepare(search.state.fit.vector), done.starts))
    rows = kept / blank.step
    size = signal_of(problem, search.sight.bin_size)
    shares = []
    for one in search.sought:
        vector = problem.prepare(one.hidden.at(one.size))
        moved = problem.flatten(problem.simulate(vector, done.starts))
        change = projector.project(np.nan_to_num(moved - base))
        grown = growth_of(replace(done, residual=change), len(filled.channels), rows)
        whole = replace(grown, gradient=grown.gradient + one.old.gradient, loss=grown.loss + one.old.loss)
        reached = left_apart(search.sight.normal, whole) / _needed(search, one, (rows, size))
        shares.append((reached - one.begun) / (1.0 - one.begun))
    return Outlook(candidate=candidate, lengths=kept, shares=np.stack(shares, axis=1))


def _needed(search: Search, one: Sought, rest: tuple[FloatArray, float]) -> FloatArray:
    """Return the distance at which an effect is named from old and new records together, shape (K,).

    Args:
        search: the old ones.
        one: the effect.
        rest: samples of the new one, shape (K,), and the size of its outputs in units of one sample's noise.
    """
    rows, size = rest
    options, sight = search.options, search.sight
    old, new = sight.problem.counted, rows * len(search.stage.template.channels)
    signal = np.sqrt((old * sight.signal**2 + new * size**2) / (old + new))
    visible = np.maximum(options.material_noise, options.material_signal * signal)
    enough = options.alarm + options.per_parameter * one.hidden.free
    return np.asarray(np.maximum(enough, visible**2 * (old + new) * sight.bin_size))


def _discovery(search: Search, outlook: Outlook, k: int) -> Discovery:
    """Return the proposal and from which strength on each effect would show in old and new records together."""
    found = []
    for one, share in zip(search.sought, outlook.shares[k], strict=True):
        # The distance grows with about the square of the strength.
        reached = max(1e-9, one.begun + share * (1.0 - one.begun))
        then = one.size / float(np.sqrt(reached))
        if then < SHOWN * one.now:
            hidden = one.hidden
            found.append(
                Revealed(id=hidden.id, parameter=hidden.parameter, unit=hidden.unit, now=one.now, then=then)
            )
    worth = float(np.mean(np.clip(outlook.shares[k], 0.0, 1.0)))
    proposal = Proposal(
        excitation=outlook.candidate.excitation, duration_s=float(outlook.lengths[k]), worth=worth
    )
    return Discovery(proposal=proposal, reveals=tuple(sorted(found, key=lambda one: one.then / one.now)))
