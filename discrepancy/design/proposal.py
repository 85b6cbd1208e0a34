"""Choose the experiment that settles a question in the least rig time.

Every candidate is simulated once; information grows along the record, so that one look gives what it would settle for
each length. The candidates that are predicted to settle the question soonest are varied (amplitude, pace), and the best
of all are looked at again with rivals that are really fitted, to the old records and the new one.

A pair of rivals counts as separated when its predicted distance reaches what the search asks for before it stops to
call them equivalent; a parameter counts as measured when its predicted error reaches the goal. A candidate's worth is
the mean over all of this of how much it reaches, so that one pair that nothing separates does not hide what is to be
gained for the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discrepancy.design.excitations import RAMP_S, Candidate, candidate_excitations, variations
from discrepancy.design.information import errors_left, growth_of, known_before, left_apart
from discrepancy.design.limits import Excitation
from discrepancy.design.prediction import Stage, beside, blank_series, predict, refitted_distance
from discrepancy.design.question import Question
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.problem import COARSE_STEP_ANGLE
from discrepancy.search.state import State

FloatArray = NDArray[np.float64]

SCREEN_S = 10.0
SLOW_SCREEN_S = 40.0
DURATIONS_S = (2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 14.0, 20.0, 28.0, 40.0, 56.0, 80.0)
VARIED = 3
"""Candidates whose neighbours are looked at."""
REFITTED = 3
"""Candidates that are looked at with a full refit."""
LENGTHENED = 2
"""How often a candidate is made longer where the refit promises less than its linearisation did."""
ENOUGH = 0.95
LEAST_WORTH = 0.05
"""Below this share of what is needed in the longest record, a proposal would waste the rig's time."""
SLOW_DRIVERS = frozenset({"time_s"})


@dataclass(frozen=True, slots=True, kw_only=True)
class Proposal:
    """A chosen experiment.

    Attributes:
        worth: reached share of what is needed, 0 to 1, mean over pairs and parameters.
        distances: predicted distance of the first rival from each other one, in noise variances.
        errors: predicted relative standard errors of the wanted parameters.
    """

    excitation: Excitation
    duration_s: float
    worth: float
    distances: tuple[float, ...] = ()
    errors: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Outlook:
    """What a candidate promises for each length that it may have.

    Attributes:
        lengths: s, shape (K,).
        shares: reached part of what each pair and each parameter needs, shape (K, items), not capped.
    """

    candidate: Candidate
    lengths: FloatArray
    shares: FloatArray

    def worths(self, items: NDArray[np.bool_]) -> FloatArray:
        """Return the mean share of the items that count, shape (K,)."""
        return np.asarray(np.mean(np.minimum(1.0, self.shares[:, items]), axis=1))


def durations(stage: Stage) -> list[float]:
    """Return the lengths that may be proposed, s."""
    longest = stage.limits.longest_s
    return [one for one in DURATIONS_S if one <= longest] or [longest]


def screening_length(stage: Stage, state: State) -> float:
    """Return the length at which candidates are compared: drifts need a long record to show at all."""
    slow = any(EFFECTS[name].driver in SLOW_DRIVERS for name in state.added)
    wanted = SLOW_SCREEN_S if slow else SCREEN_S
    return min(wanted, durations(stage)[-1])


def propose(stage: Stage, question: Question) -> Proposal | None:
    """Return the experiment that settles a question soonest, None if the limits allow nothing that helps."""
    length = screening_length(stage, question.rivals[0].state)
    coarse = replace(stage, step_angle=COARSE_STEP_ANGLE)

    def glance(candidates: Sequence[Candidate]) -> list[Outlook]:
        looked = [_look(coarse, question, one, length) for one in candidates]
        return [one for one in looked if one is not None]

    outlooks = glance(candidate_excitations(stage.limits))
    if not outlooks:
        return None
    best = np.max([one.shares.max(axis=0) for one in outlooks], axis=0)
    items = best >= LEAST_WORTH
    if not items.any():
        return None
    leaders = [one for one, _ in _ranked(outlooks, items)[:VARIED]]
    outlooks += glance([more for one in leaders for more in variations(one.candidate, stage.limits)])
    return _confirmed(stage, question, _ranked(outlooks, items), items)


def _look(stage: Stage, question: Question, candidate: Candidate, length: float) -> Outlook | None:
    """Return what a candidate promises for every length that keeps inside the limits."""
    first, others = question.rivals[0].state, [one.state for one in question.rivals[1:]]
    lengths = durations(stage)
    blank = blank_series(stage, candidate.excitation, length)
    found = predict(stage, blank, first, others, min(lengths[0], length))
    if found is None:
        return None
    predicted, inside = found
    longest = max(lengths) if inside >= length else inside
    kept = np.array([one for one in lengths if one <= longest])
    rows = kept / blank.step
    channels = len(predicted.channels)
    shares = [
        left_apart(rival.fit.normal(), growth_of(beside(stage, predicted, rival), channels, rows))
        / np.array([question.needed(float(one), i) for one in kept])
        for i, rival in enumerate(others)
    ]
    if question.wanted:
        left = errors_left(
            known_before(first.fit), growth_of(beside(stage, predicted, first), channels, rows)
        )
        shares += [one.share(left[:, one.index]) for one in question.wanted]
    return Outlook(candidate=candidate, lengths=kept, shares=np.stack(shares, axis=1))


def _ranked(outlooks: Sequence[Outlook], items: NDArray[np.bool_]) -> list[tuple[Outlook, float]]:
    """Return the candidates with the length each needs, those that reach what any can reach soonest first."""
    target = ENOUGH * max(float(one.worths(items).max()) for one in outlooks)
    timed: list[tuple[float, float, int]] = []
    for i, one in enumerate(outlooks):
        enough = np.flatnonzero(one.worths(items) >= target)
        if enough.size:
            k = int(enough[0])
            timed.append((float(one.lengths[k]), -float(np.min(one.shares[k, items])), i))
    return [(outlooks[i], duration) for duration, _, i in sorted(timed)]


def _confirmed(
    stage: Stage,
    question: Question,
    ranked: Sequence[tuple[Outlook, float]],
    items: NDArray[np.bool_],
) -> Proposal | None:
    """Look again at the best candidates that the rig takes, with rivals that are fitted; return the shortest."""
    found: list[Proposal] = []
    for outlook, duration in ranked:
        if len(found) == REFITTED:
            break
        if stage.limits.allows(_faded(outlook.candidate.excitation), duration):
            proposal = _settling(stage, question, (outlook.candidate, duration), items)
            found += [] if proposal is None else [proposal]
    most = max((one.worth for one in found), default=0.0)
    if most < LEAST_WORTH:
        return None
    enough = [one for one in found if one.worth >= ENOUGH * most]
    return min(enough, key=lambda one: (one.duration_s, -one.worth, -sum(one.distances)))


def _settling(
    stage: Stage, question: Question, start: tuple[Candidate, float], items: NDArray[np.bool_]
) -> Proposal | None:
    """Return a candidate at the first length at which the refit confirms it, or at the longest that was tried."""
    candidate, duration = start
    best = None
    longer = [one for one in durations(stage) if one > duration][:LENGTHENED]
    for length in (duration, *longer):
        if best is not None and not stage.limits.allows(_faded(candidate.excitation), length):
            break
        proposal = _fitted(stage, question, candidate, (length, items))
        if proposal is None:
            break
        best = proposal
        if best.worth >= ENOUGH:
            break
    return best


def _fitted(
    stage: Stage, question: Question, candidate: Candidate, rest: tuple[float, NDArray[np.bool_]]
) -> Proposal | None:
    """Return what a record of one length promises, rivals fitted."""
    length, items = rest
    first, others = question.rivals[0].state, [one.state for one in question.rivals[1:]]
    blank = blank_series(stage, candidate.excitation, length)
    found = predict(stage, blank, first, others, length)
    if found is None:
        return None
    predicted = found[0]
    far = tuple(refitted_distance(stage, predicted, one) for one in others)
    shares = [d / question.needed(length, i) for i, d in enumerate(far)]
    errors: list[float] = []
    if question.wanted:
        rows = np.array([predicted.n], dtype=np.float64)
        grown = growth_of(beside(stage, predicted, first), len(predicted.channels), rows)
        left = errors_left(known_before(first.fit), grown)[0]
        shares += [float(one.share(left[one.index])) for one in question.wanted]
        errors = [one.known * float(left[one.index]) for one in question.wanted]
    worth = float(np.mean(np.minimum(1.0, np.array(shares)[items])))
    return Proposal(
        excitation=candidate.excitation, duration_s=length, worth=worth, distances=far, errors=tuple(errors)
    )


def _faded(excitation: Excitation) -> dict[str, Any]:
    """Return the excitation as the campaign will play it."""
    return {**excitation, "ramp_s": RAMP_S}
