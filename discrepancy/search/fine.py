"""Search on in finer samples once play is in the model.

Contacts bend a motion within a few milliseconds. From bin to bin the simulation of the means misses them, at the true
parameters too, and further effects drown in what it leaves (measured: benchmarks/blind/development.md).
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.series import Series, bin_series
from discrepancy.effects.spec import Ranges
from discrepancy.fitting.problem import COARSE_STEP_ANGLE, Noise, SimulationProblem
from discrepancy.search.context import Context
from discrepancy.search.greedy import closed_amount
from discrepancy.search.outcome import Step
from discrepancy.search.state import refit

FloatArray = NDArray[np.float64]

_ITERATIONS = 6
SCOUT_FACTOR = 2
"""Starts are tried on samples so many times coarser than those that decide."""


def scout_problem(problem: SimulationProblem) -> SimulationProblem:
    """Return the problem on coarser samples, on which starts are tried."""
    coarse = tuple(bin_series(one, SCOUT_FACTOR) for one in problem.series)
    longest = SCOUT_FACTOR * problem.longest_step
    return replace(problem, series=coarse, step_angle=COARSE_STEP_ANGLE, longest_step=longest)


def on_fine(
    problem: SimulationProblem, context: Context, steps: Sequence[Step], ranges: Ranges
) -> tuple[SimulationProblem, Context, tuple[Step, ...]]:
    """Return problem, context and steps in the context's finer samples; as they are where there are none.

    Args:
        problem: with white noise weights.
        context: what the search needs besides.
        steps: accepted models, base first.
        ranges: sizes of the signals.
    """
    fine = context.fine
    if fine is None or fine.series[0].step >= problem.series[0].step:
        return problem, context, tuple(steps)
    less = _bin_size(context.bin_size, problem.series[0], fine.series[0])
    names = [channel.name for channel in problem.series[0].channels]
    wider = dict(zip(names, np.broadcast_to(np.sqrt(context.bin_size / less), len(names)), strict=True))
    known = context.repeat_noise
    fine = replace(fine, noise=_widened(problem.noise, wider))
    context = replace(
        context,
        bin_size=less,
        fine=fine,
        scout=scout_problem(fine),
        pairs=(),
        repeat_noise=None if known is None else _widened(known, wider),
    )
    moved: list[Step] = []
    for step in steps:
        state = refit(fine, step.state, ranges, _ITERATIONS)
        closed = closed_amount(fine, context, (moved[-1].state, state)) if moved else step.closed
        moved.append(replace(step, state=state, closed=closed))
    total = np.sqrt(sum((step.closed**2 for step in moved[1:]), np.zeros(1)))
    return fine, replace(context, closed=total), tuple(moved)


def _bin_size(bin_size: FloatArray, coarse: Series, fine: Series) -> FloatArray:
    """Return the variance of one sample over that of a finer bin, by a power law of the bin's length, shape (C,)."""
    original = coarse.original_step
    return np.asarray(bin_size ** (math.log(fine.step / original) / math.log(coarse.step / original)))


def _widened(noise: Noise, wider: dict[str, float]) -> Noise:
    """Return the noise of finer samples: larger, and white, since what was known of its colour belongs to the bins."""
    return Noise(sigma={name: sigma * float(wider[name]) for name, sigma in noise.sigma.items()})
