"""One simulated point of a fit, and what of its residual the windows' starting states could explain."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discrepancy.fitting.problem import SimulationProblem, Starts

FloatArray = NDArray[np.float64]

STEEPEST = 1e9
"""Sensitivities are cut off here: those of a simulation that runs away say nothing."""
_RUNAWAY = 1e6
_TOLERANCE = 3e-5
_MOVES = 3
QUIET = np.errstate(over="ignore", invalid="ignore")
"""Decorates what fits: a trial whose simulation runs away loses, which is no reason to warn anybody."""


def _pseudo_inverse(block: FloatArray) -> FloatArray:
    """Return the pseudo-inverse, shape (k, n), of start sensitivities, shape (n, k); one column needs no SVD."""
    if block.shape[1] > 1:
        return np.asarray(np.linalg.pinv(block, rcond=1e-9))
    power = float(block[:, 0] @ block[:, 0])
    return block.T / power if power > 0.0 else np.zeros(block.T.shape)


def bounded(values: FloatArray, limit: float, nan: float = 0.0) -> FloatArray:
    """Return values that are finite and within the limit; `nan` stands for what is no number."""
    if np.max(values, initial=0.0) <= limit and np.min(values, initial=0.0) >= -limit:  # both False for a NaN
        return values
    return np.asarray(np.clip(np.nan_to_num(values, nan=nan), -limit, limit))


class Point:
    """One evaluated point: simulation, residual, start sensitivities."""

    def __init__(
        self, problem: SimulationProblem, data: FloatArray, vector: FloatArray, starts: Starts
    ) -> None:
        self.vector, self.starts = vector, starts
        self.outputs = problem.simulate(vector, starts)
        # A trial that runs away must lose, not raise.
        self.raw = bounded(data - problem.flatten(self.outputs), _RUNAWAY, _RUNAWAY)


class Projector:
    """Removes what the starting states can explain, window by window."""

    def __init__(self, problem: SimulationProblem, point: Point) -> None:
        columns = problem.start_columns(point.vector, point.starts, point.outputs)
        self.slices = problem.window_slices() if columns else []
        self.bases = []
        self.inverses = []
        for parts in self.slices:
            block = np.stack([np.concatenate([c[part] for part in parts]) for c in columns], axis=1)
            block = bounded(block, STEEPEST)
            norm = np.linalg.norm(block, axis=0)
            block[:, norm < 1e-9] = 0.0
            self.bases.append(block)
            self.inverses.append(_pseudo_inverse(block))

    def coefficients(self, values: FloatArray) -> list[FloatArray]:
        """Return the start changes that explain `values` best, one array a window."""
        return [
            inverse @ np.concatenate([values[part] for part in parts])
            for parts, inverse in zip(self.slices, self.inverses, strict=True)
        ]

    def project(self, values: FloatArray) -> FloatArray:
        """Return `values` without what the starts explain; shape (N,) or (N, p)."""
        if len(self.slices) == 1 and len(self.slices[0]) == 1:
            return np.asarray(values - self.bases[0] @ (self.inverses[0] @ values))
        result = values.copy()
        for parts, base, inverse in zip(self.slices, self.bases, self.inverses, strict=True):
            whole = np.concatenate([values[part] for part in parts])
            whole = whole - base @ (inverse @ whole)
            at = 0
            for part in parts:
                size = part.stop - part.start
                result[part] = whole[at : at + size]
                at += size
        return result


def moved_starts(problem: SimulationProblem, starts: Starts, changes: list[FloatArray]) -> Starts:
    """Return the starting states with each window's changes added, one array a window in the order of `start_rows`."""
    rows = problem.start_rows(starts) if changes else ()
    moved = tuple(start.copy() for start in starts)
    window = 0
    for start in moved:
        for m in range(start.shape[0]):
            for column, row in enumerate(rows):
                start[m, row] += changes[window][column]
            window += 1
    return moved


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedStarts:
    """Starting states fitted to the measurement; `loss` is the sum of squares of what is really left, weighted."""

    starts: Starts
    outputs: list[FloatArray]
    loss: float


@QUIET
def fit_starts(problem: SimulationProblem, vector: FloatArray, starts: Starts) -> FittedStarts:
    """Fit the starting states of all windows alone, at fixed parameters, by Gauss-Newton steps on the true residual.

    A fit (`levenberg`) cannot: its loss has the starts projected out already, so that no change of them lowers it.
    """
    data, vector = problem.measured(), problem.prepare(vector)
    point = Point(problem, data, vector, problem.with_inner_states(vector, starts))
    loss = float(point.raw @ point.raw)
    for _ in range(_MOVES):
        projector = Projector(problem, point)
        left = projector.project(point.raw)
        if loss - float(left @ left) <= _TOLERANCE * loss:
            break
        moved = moved_starts(problem, point.starts, projector.coefficients(point.raw))
        trial = Point(problem, data, point.vector, moved)
        reached = float(trial.raw @ trial.raw)
        if reached >= loss:
            break
        point, loss = trial, reached
    return FittedStarts(starts=point.starts, outputs=point.outputs, loss=loss)
