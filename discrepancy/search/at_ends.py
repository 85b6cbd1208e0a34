"""Whether an answer rests on the first and last moments of the records, where a smoothed speed is wrong."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.ends import end_samples
from discrepancy.data.series import SPEED
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.outcome import Step
from discrepancy.search.state import State

FloatArray = NDArray[np.float64]
DECISIVE = 0.5
"""A name rests on the ends where more than this part of what it closed lies in them."""
LOUD = 2.0
"""The ends err where a model leaves so many times more there than elsewhere, mean squares."""


def ends_decide(problem: SimulationProblem, steps: Sequence[Step], doubted: bool) -> bool:
    """Return whether the records' ends have made an answer what it is.

    Args:
        problem: with speeds among its outputs, or without: then they have not.
        steps: the accepted models before any is taken back, base first.
        doubted: whether something is left that no name explains.
    """
    ends = _ends(problem)
    if not ends.any():
        return False
    squares = [_squares(problem, step.state) for step in steps]
    closed = [before - after for before, after in zip(squares, squares[1:], strict=False)]
    if any(one[ends].sum() > DECISIVE * one.sum() > 0.0 for one in closed):
        return True
    left = squares[-1]
    counted = left > 0.0
    return doubted and bool(left[ends & counted].mean() > LOUD * left[~ends & counted].mean())


def _ends(problem: SimulationProblem) -> NDArray[np.bool_]:
    """Return which flattened samples are speeds at the ends of a record."""
    parts = []
    for one in problem.series:
        few = end_samples(one)
        for channel in one.channels:
            part = np.zeros(one.n, dtype=bool)
            if channel.row == SPEED and few:
                part[:few] = part[-few:] = True
            parts.append(part)
    return np.concatenate(parts)


def _squares(problem: SimulationProblem, state: State) -> FloatArray:
    """Return the squared weighted residual of each flattened sample."""
    outputs = problem.simulate(problem.prepare(state.fit.vector), state.fit.starts)
    return np.asarray((problem.measured() - problem.flatten(outputs)) ** 2)
