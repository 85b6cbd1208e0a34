"""Choose the experiment that settles a question in the least rig time.

Every candidate is simulated once; information grows along the record, so that one look gives what it would settle for
each length. The candidates that are predicted to settle most of the question per second are varied (amplitude, pace),
and the best of all are looked at again with rivals that are really fitted, to the old records and the new one. What a
record costs beside its length counts too: a question that one record settles is not cut into many. One that would take
long is: what the first record tells changes what is left to ask.

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
OVERHEAD_S = 5.0
"""What a record costs beside its length: the joint is brought to its start, and the question asked again."""
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

    @property
    def rate(self) -> float:
        """Return what it settles for what it costs, 1/s."""
        return self.worth / (self.duration_s + OVERHEAD_S)


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
    leaders = [one for one, _ in ranked(outlooks, items)[:VARIED]]
    outlooks += glance([more for one in leaders for more in variations(one.candidate, stage.limits)])
    return _confirmed(stage, question, ranked(outlooks, items), items)


def _look(stage: Stage, question: Question, candidate: Candidate, length: float) -> Outlook | None:
    """Return what a candidate promises for every length that keeps inside the limits."""
    first, others = question.rivals[0].state, [one.state for one in question.rivals[1:]]
    lengths = durations(stage)
    blank = blank_series(stage, candidate.excitation, length)
    found = predict(stage, blank, first, others, min(lengths[0], length))
    if found is None:
        return None
    predicted, inside = found
    # A record is a whole number of samples, which may be a little less than the length that was asked for.
    longest = max(lengths) if inside >= length - blank.step else inside
    kept = np.array([one for one in lengths if one <= longest + blank.step])
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


def ranked(outlooks: Sequence[Outlook], items: NDArray[np.bool_]) -> list[tuple[Outlook, int]]:
    """Return the candidates, each with the place of its best length, those that settle most per second first."""
    rated: list[tuple[float, float, int, int]] = []
    for i, one in enumerate(outlooks):
        rates = one.worths(items) / (one.lengths + OVERHEAD_S)
        k = int(np.argmax(rates))
        rated.append((-float(rates[k]), -float(np.min(one.shares[k, items])), i, k))
    return [(outlooks[i], k) for _, _, i, k in sorted(rated)]


def _confirmed(
    stage: Stage,
    question: Question,
    best_first: Sequence[tuple[Outlook, int]],
    items: NDArray[np.bool_],
) -> Proposal | None:
    """Look again at the best candidates that the rig takes, with rivals that are fitted; return the best of them."""
    found: list[Proposal] = []
    for outlook, k in best_first:
        if len(found) == REFITTED:
            break
        if stage.limits.allows(_faded(outlook.candidate.excitation), float(outlook.lengths[k])):
            proposal = _settling(stage, question, (outlook, k), items)
            found += [] if proposal is None else [proposal]
    most = max((one.worth for one in found), default=0.0)
    if most < LEAST_WORTH:
        return None
    return max(found, key=lambda one: (one.rate, one.worth, sum(one.distances)))


def _settling(
    stage: Stage, question: Question, start: tuple[Outlook, int], items: NDArray[np.bool_]
) -> Proposal | None:
    """Return a candidate at the first length at which the refit confirms it, or at the longest that was tried."""
    outlook, k = start
    candidate, duration = outlook.candidate, float(outlook.lengths[k])
    promised = float(outlook.worths(items)[k])
    best = None
    longer = [one for one in durations(stage) if one > duration][:LENGTHENED]
    for length in (duration, *longer):
        if best is not None and not stage.limits.allows(_faded(candidate.excitation), length):
            break
        proposal = _fitted(stage, question, candidate, (length, items))
        if proposal is None:
            break
        best = proposal
        if best.worth >= ENOUGH * promised:
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
