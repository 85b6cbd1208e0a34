"""Sums of squares output by output.

A current that the drive measures to a milliampere and a speed derived from a potentiometer are both outputs; in one sum
the quiet one would drown the other. Every limit that says how much is visible is asked of each output by itself.
"""

import numpy as np
from numpy.typing import NDArray

from discrepancy.fitting.problem import SimulationProblem

FloatArray = NDArray[np.float64]


def output_losses(problem: SimulationProblem, residual: FloatArray) -> FloatArray:
    """Return the part of each output in the sum of squares of a flattened residual, shape (C,)."""
    losses = np.zeros(len(problem.series[0].channels))
    at = 0
    for one in problem.series:
        for c in range(len(one.channels)):
            part = residual[at : at + one.n]
            losses[c] += part @ part
            at += one.n
    return losses


def output_rows(problem: SimulationProblem) -> FloatArray:
    """Return the number of flattened samples of each output that are measurements, shape (C,)."""
    counts = [[np.count_nonzero(c.weight) for c in one.channels] for one in problem.series]
    return np.asarray(np.sum(counts, axis=0), dtype=np.float64)


def output_counts(problem: SimulationProblem) -> FloatArray:
    """Return how many samples each sum of squares stands for, shape (C,); a mean of m repeats counts m times."""
    counts = [[float(c.weight @ c.weight) for c in one.channels] for one in problem.series]
    return np.asarray(np.sum(counts, axis=0), dtype=np.float64)
