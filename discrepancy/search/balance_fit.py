"""Whose parameters predict a simulated position: those of a long free run or those of the torque balance?

A free run counts every force error for as long as the position remembers it, so its fit bends a parameter that the
position hardly shows (a mass) until it cancels what a law leaves over this very course of the motion. Where the motion
repeats itself, so does that cancellation, and a later period of the same motion cannot tell. So the parts that are
held out here are kinds of motion that the fit has not seen: a third of the period in all periods at once, or a third
of the record where the motion does not repeat itself.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.series import Series
from discrepancy.fitting.free_run import MOST_WINDOWS, best_free_run
from discrepancy.fitting.levenberg import fit
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.halves import part_of
from discrepancy.search.outcome import SearchOutcome, Step
from discrepancy.search.standard_errors import standard_errors
from discrepancy.search.state import State

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

KINDS = 3
REPEATS_WITHIN = 0.05
"""A motion repeats itself after a time if it then differs by less than this part of what two unrelated pieces do."""
_FEWEST = 50
_ITERATIONS = 8


def choose_parameters(
    outcome: SearchOutcome, balance: SearchOutcome, whole: Sequence[Series]
) -> SearchOutcome:
    """Return the outcome with the last model's parameters from the torque balance where these predict better.

    Args:
        outcome: named, its models fitted to free runs.
        balance: found by the torque balance of the same records.
        whole: the records, cut at holes only.
    """
    last, other = outcome.steps[-1].state, balance.steps[-1].state
    if not last.added or last.is_chaotic or sorted(last.added) != sorted(other.added):
        return outcome
    if KINDS * max(len(one.windows) for one in whole) > MOST_WINDOWS:
        return outcome
    labels = [motion_kinds(one) for one in whole]
    mine, others = _held_out(outcome.problem, balance.problem, (last, other), (whole, labels))
    if not others < mine:
        return outcome
    windows = outcome.problem
    steps = (*outcome.steps[:-1], _taken(outcome.steps[-1], balance, windows))
    size = windows.noise.sigma[windows.series[0].channels[0].name]
    note = (
        "the last model's parameters are those of the torque balance: over parts of the motion that were not fitted "
        f"they err by {size * others:.2g}, those of a fit to the free run by {size * mine:.2g} (rms, in the output's "
        "unit)"
    )
    return replace(outcome, steps=steps, notes=(*outcome.notes, note))


def _taken(step: Step, balance: SearchOutcome, windows: SimulationProblem) -> Step:
    """Return the last step with the parameters of the torque balance's last model, and their standard errors."""
    state = balance.steps[-1].state
    errors = standard_errors(balance.problem, state.fit, (None, balance.ranges))
    moved = fit(windows, step.state.fit.parameters, state.fit.vector, windows.initial_starts(), 0)
    known = {p.slot: float(error) for p, error in zip(state.fit.parameters, errors, strict=True)}
    # What only the simulation has (a smoothing of the output) is none of the joint's parameters.
    own = np.array([known.get(p.slot, 0.0) for p in moved.parameters])
    return replace(step, state=replace(step.state, fit=moved), errors=own)


def motion_kinds(one: Series) -> IntArray:
    """Return to which of three kinds of motion each sample belongs, shape (n,)."""
    length = period_samples(one.angle) or one.n
    return np.asarray(KINDS * (np.arange(one.n) % length) // length, dtype=np.int64)


def period_samples(angle: FloatArray) -> int | None:
    """Return after how many samples a motion repeats itself; None where a record does not hold two periods."""
    n, spread = angle.size, float(np.std(angle))
    if spread <= 0.0:
        return None
    coarse = max(1, n // 2000)
    values = (angle - angle.mean())[::coarse] / (spread * np.sqrt(2.0))
    lags = np.arange(1, values.size // 2 + 1)
    differs = np.array([np.sqrt(np.mean((values[k:] - values[:-k]) ** 2)) for k in lags])
    left = int(np.argmax(differs > 0.5))  # beyond this lag a small difference is a return, not a short time
    repeats = left + np.flatnonzero(differs[left:] < REPEATS_WITHIN)
    if differs[left] <= 0.5 or not repeats.size:
        return None
    valley = repeats[: int(np.argmax(np.diff(np.r_[repeats, values.size]) > 1)) + 1]
    return int(lags[valley[np.argmin(differs[valley])]]) * coarse


def _held_out(
    problem: SimulationProblem,
    balance: SimulationProblem,
    states: tuple[State, State],
    records: tuple[Sequence[Series], Sequence[IntArray]],
) -> tuple[float, float]:
    """Return rms errors over each kind of motion, fitted to the others: by the free run, by the torque balance."""
    last, other = states
    whole, labels = records
    losses, rows = np.zeros(2), 0.0
    for kind in range(KINDS):
        used = replace(problem, series=_pieces(whole, [label != kind for label in labels]))
        held = replace(problem, series=_pieces(whole, [label == kind for label in labels]))
        if not used.series or not held.series:
            continue
        part = _without(balance, whole, [label == kind for label in labels])
        free = best_free_run(used, last.fit.parameters, last.fit.vector).vector
        force = fit(part, other.fit.parameters, other.fit.vector, part.initial_starts(), _ITERATIONS).vector
        losses += [best_free_run(held, (), vector).loss for vector in (free, force)]
        rows += held.rows
    mine, others = np.sqrt(losses / max(rows, 1.0))
    return float(mine), float(others)


def _pieces(whole: Sequence[Series], chosen: Sequence[NDArray[np.bool_]]) -> tuple[Series, ...]:
    """Return the contiguous pieces of the records that are chosen; a few samples are no piece."""
    found: list[Series] = []
    for one, rows in zip(whole, chosen, strict=True):
        edges = np.flatnonzero(np.diff(np.r_[False, rows, False]))
        found.extend(part_of(one, int(a), int(b)) for a, b in pairwise(edges) if rows[a] and b - a >= _FEWEST)
    return tuple(found)


def _without(
    balance: SimulationProblem, whole: Sequence[Series], hidden: Sequence[NDArray[np.bool_]]
) -> SimulationProblem:
    """Return the torque balance with the hidden times not judged."""
    series = []
    for one, judged, rows in zip(whole, balance.series, hidden, strict=True):
        at = np.clip(np.searchsorted(one.time_s, judged.time_s), 0, one.n - 1)
        channels = tuple(replace(c, weight=c.weight * ~rows[at]) for c in judged.channels)
        series.append(replace(judged, channels=channels))
    return replace(balance, series=tuple(series))
