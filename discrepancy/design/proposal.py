"""Choose the experiment: score all by linearised predictions, refit for the best few, take the shortest that does.

A pair of rivals counts as separated when its predicted distance reaches what the search asks for before it stops to
call them equivalent. A candidate's worth is the mean over the pairs of how much of that it reaches, so that one pair
that nothing separates does not hide what is to be gained for the others.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from discrepancy.data.series import Series
from discrepancy.design.excitations import RAMP_S, Candidate, candidate_excitations
from discrepancy.design.limits import Excitation
from discrepancy.design.prediction import (
    Stage,
    blank_series,
    linear_distance,
    predict,
    refitted_distance,
    worst_error,
)
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.problem import COARSE_STEP_ANGLE
from discrepancy.search.state import State

SCREEN_S = 20.0
DURATIONS_S = (5.0, 10.0, 20.0, 40.0, 80.0)
REFITTED = 3
"""Candidates that are looked at with a full refit."""
TIMED = 2
"""Of these, candidates that are looked at in every length."""
ENOUGH = 0.95
LEAST_WORTH = 0.05
"""Below this share of what is needed in the longest record, a proposal would waste the rig's time."""
SLOW_DRIVERS = frozenset({"time_s"})

Needed = Callable[[float], float]
Distance = Callable[[Stage, Series, State], float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Rival:
    """A fitted model that explains the data as well as others do."""

    name: str
    state: State


@dataclass(frozen=True, slots=True, kw_only=True)
class Proposal:
    """A chosen experiment.

    Attributes:
        worth: reached share of what is needed, 0 to 1, mean over the pairs.
        distances: predicted distance of the first rival from each other one, in noise variances.
    """

    excitation: Excitation
    duration_s: float
    worth: float
    distances: tuple[float, ...] = ()


def durations(stage: Stage) -> list[float]:
    """Return the lengths that may be proposed, s."""
    longest = stage.limits.longest_s
    return [one for one in DURATIONS_S if one <= longest] or [longest]


def screening_length(stage: Stage, state: State) -> float:
    """Return the length at which candidates are compared: drifts need a long record to show at all."""
    slow = any(EFFECTS[name].driver in SLOW_DRIVERS for name in state.added)
    wanted = DURATIONS_S[-1] if slow else SCREEN_S
    return min(wanted, durations(stage)[-1])


def separate(stage: Stage, rivals: Sequence[Rival], needed: Needed) -> Proposal | None:
    """Return what tells the first rival from the others best, None if the limits allow nothing that helps."""
    first, others = rivals[0].state, [one.state for one in rivals[1:]]
    length = screening_length(stage, first)
    coarse = replace(stage, step_angle=COARSE_STEP_ANGLE)

    def glance(candidate: Candidate) -> Proposal | None:
        return look(candidate, length, (coarse, linear_distance))

    def look(candidate: Candidate, duration: float, way: tuple[Stage, Distance]) -> Proposal | None:
        at, distance = way
        predicted = predict(at, blank_series(at, candidate.excitation, duration), first, others)
        if predicted is None:
            return None
        far = tuple(distance(at, predicted, other) for other in others)
        worth = float(np.mean([min(1.0, d / needed(duration)) for d in far]))
        return Proposal(excitation=candidate.excitation, duration_s=duration, worth=worth, distances=far)

    scored = _screen(stage, [(c, glance(c)) for c in candidate_excitations(stage.limits)])
    refitted = [(c, look(c, length, (stage, refitted_distance))) for c, _ in scored[:REFITTED]]
    best = _screen(stage, refitted)
    if not best:
        return None
    return _shortest(stage, [c for c, _ in best[:TIMED]], lambda c, t: look(c, t, (stage, refitted_distance)))


def measure(stage: Stage, state: State, owner: str, goal: float) -> Proposal | None:
    """Return the experiment that brings an effect's parameters to a relative standard error of `goal`, or nearest."""
    length = screening_length(stage, state)
    begin = worst_error(stage, None, state, owner)

    def look(candidate: Candidate, duration: float) -> Proposal | None:
        predicted = predict(stage, blank_series(stage, candidate.excitation, duration), state, ())
        if predicted is None:
            return None
        left = worst_error(stage, predicted, state, owner)
        gained = math.log(begin / left) if left > 0.0 else math.inf
        worth = min(1.0, max(0.0, gained) / max(math.log(begin / goal), 1e-9))
        return Proposal(excitation=candidate.excitation, duration_s=duration, worth=worth, distances=(left,))

    best = _screen(stage, [(c, look(c, length)) for c in candidate_excitations(stage.limits)])
    return _shortest(stage, [c for c, _ in best[:TIMED]], look)


def _screen(
    stage: Stage, looked: Sequence[tuple[Candidate, Proposal | None]]
) -> list[tuple[Candidate, Proposal]]:
    """Return the best candidates that the rig takes, best first; the rig is asked about no more than are wanted."""
    ranked = sorted(
        ((c, p) for c, p in looked if p is not None), key=lambda pair: _merit(pair[1]), reverse=True
    )
    taken: list[tuple[Candidate, Proposal]] = []
    for candidate, proposal in ranked:
        if len(taken) < REFITTED and stage.limits.allows(_faded(candidate.excitation), proposal.duration_s):
            taken.append((candidate, proposal))
    return taken


def _merit(proposal: Proposal) -> tuple[float, float]:
    """Return what orders proposals: the worth, then the distance beyond what is needed."""
    return round(proposal.worth, 2), sum(proposal.distances)


def _shortest(
    stage: Stage, candidates: Sequence[Candidate], look: Callable[[Candidate, float], Proposal | None]
) -> Proposal | None:
    """Return the shortest experiment that is worth nearly as much as any."""
    found: list[Proposal] = []
    for duration in durations(stage):
        looked = [look(one, duration) for one in candidates]
        fitting = [
            p for p in looked if p is not None and stage.limits.allows(_faded(p.excitation), p.duration_s)
        ]
        found += fitting
        if any(one.worth >= ENOUGH for one in fitting):
            break
    most = max((one.worth for one in found), default=0.0)
    if most < LEAST_WORTH:
        return None
    enough = [one for one in found if one.worth >= ENOUGH * most]
    shortest = min(one.duration_s for one in enough)
    return max((one for one in enough if one.duration_s == shortest), key=_merit)


def _faded(excitation: Excitation) -> dict[str, Any]:
    """Return the excitation as the campaign will play it."""
    return {**excitation, "ramp_s": RAMP_S}
