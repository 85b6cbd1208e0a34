"""Fit the accepted models again over the whole records, where windows were used to find them.

A position drifts: windows of a few seconds keep a search away from what a long free run makes of a small mistake. The
long free run then tells the parameters far better than windows do (a constant force of 0.1 N is nothing in two
seconds and centimetres in half a minute).
"""

from collections.abc import Sequence
from dataclasses import replace

from discrepancy.data.series import Series
from discrepancy.fitting.free_run import MOST_WINDOWS, best_free_run
from discrepancy.fitting.levenberg import fit
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.outcome import SearchOutcome, Step
from discrepancy.search.state import State


def refine_free_run(outcome: SearchOutcome, whole: Sequence[Series]) -> SearchOutcome:
    """Return the outcome with every model fitted to free runs over whole records.

    Args:
        outcome: found on windows; its problem stays, so that standard errors come from many windows.
        whole: the same records, cut at holes only.
    """
    if max(len(one.windows) for one in whole) > MOST_WINDOWS:
        return outcome
    problem = replace(outcome.problem, series=tuple(whole))
    steps: list[Step] = []
    for step in outcome.steps:
        smaller = steps[-1].state if steps else None
        steps.append(replace(step, state=_refined(problem, outcome.problem, step.state, smaller)))
    return replace(outcome, steps=tuple(steps))


def _refined(
    problem: SimulationProblem, windows: SimulationProblem, state: State, smaller: State | None
) -> State:
    """Return a model fitted to free runs; one that errs more than the `smaller` one before it begins there again."""
    if state.is_chaotic:
        return state
    before = best_free_run(problem, (), state.fit.vector)
    found = best_free_run(problem, state.fit.parameters, state.fit.vector)
    if smaller is not None and found.loss > best_free_run(problem, (), smaller.fit.vector).loss:
        again = best_free_run(problem, state.fit.parameters, smaller.fit.vector)
        found = min(found, again, key=lambda one: one.loss)
    if found.loss >= before.loss:
        return state
    return replace(state, fit=fit(windows, state.fit.parameters, found.vector, windows.initial_starts(), 0))
