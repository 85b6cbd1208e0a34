"""Name what a simulated position lacks by the torque balance, where that predicts the position better.

A position is the second integral of the force: in a search over its windows the noise read off the residual is drift,
and laws are patched together to follow it. The torque balance of the same record has no such memory. Both searches
name; each list of names is fitted to free runs over one half of the records and predicts the other half, both ways
round. The shorter list stands unless the longer one predicts better by a tenth.
"""

from collections.abc import Sequence
from dataclasses import replace

from discrepancy.data.series import Series
from discrepancy.fitting.free_run import MOST_WINDOWS
from discrepancy.search.greedy import Round, closed_amount
from discrepancy.search.halves import halves_error
from discrepancy.search.outcome import SearchOutcome, Step
from discrepancy.search.state import parameters_of, refit

CLEARLY = 0.9
"""A longer list of names must err by less than this part (rms) of what a shorter one errs by."""

NOTE = (
    "the names were found by the torque balance of the training records: over halves of them they predict the "
    "position better (or as well with fewer parameters) than those found by simulation"
)


def choose_names(outcome: SearchOutcome, balance: SearchOutcome, whole: Sequence[Series]) -> SearchOutcome:
    """Return the search whose names predict the other half of the records.

    Args:
        outcome: found by simulating windows of a position.
        balance: found by the torque balance of the same records.
        whole: the records, cut at holes only.
    """
    if balance.steps[-1].state.added == outcome.steps[-1].state.added or len(balance.steps) < 2:
        return outcome
    if max(len(one.windows) for one in whole) > MOST_WINDOWS:
        return outcome
    steps = _in_simulation(outcome, balance)
    mine, other = outcome.steps[-1].state, steps[-1].state
    error, others = (halves_error(outcome.problem, one, whole) for one in (mine, other))
    if mine.size > other.size:
        stays = error <= CLEARLY * others
    else:
        stays = others >= (1.0 if mine.size == other.size else CLEARLY) * error
    if stays:
        return outcome
    return replace(
        outcome, steps=steps, rounds=_as_tried(balance), unknown=balance.unknown, notes=(*outcome.notes, NOTE)
    )


def _as_tried(balance: SearchOutcome) -> tuple[Round, ...]:
    """Return the balance's rounds as a list of what was tried: their models cannot be asked for a next experiment."""
    if balance.unknown is not None:
        return ()
    return tuple(
        replace(one, winner=None, contenders=tuple(c for c in one.contenders if c is not one.winner))
        for one in balance.rounds
    )


def _in_simulation(outcome: SearchOutcome, balance: SearchOutcome) -> tuple[Step, ...]:
    """Return the balance's steps as models of the simulation, fitted to its windows."""
    first = outcome.steps[0]
    steps, before = [first], first.state
    for step in balance.steps[1:]:
        vector = step.state.fit.vector.copy()
        parameters = parameters_of(first.state.base, first.state.given, step.state.added, outcome.ranges)
        begun = replace(first.state.fit, vector=vector, parameters=tuple(parameters))
        state = replace(first.state, added=step.state.added, fit=begun, nameplate=None)
        state = refit(outcome.problem, state, outcome.ranges)
        closed = closed_amount(outcome.problem, outcome.context, (before, state))
        steps.append(replace(step, state=state, closed=closed))
        before = state
    return tuple(steps)
