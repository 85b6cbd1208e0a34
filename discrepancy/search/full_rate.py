"""Fit the accepted model against what it does at the full sampling rate.

The search averages samples into bins and simulates from bin to bin. Where the motion or the input bends within a bin
(a contact, a limit, a soft shaft, a lag of a few bins) the simulation of the means is not the mean of the simulation,
and the fitted parameters make up for the difference: a bias that no standard error knows. Here that difference is
simulated at the fitted point and taken from the data, and the fit repeated (deferred correction, V. Pereyra, Numerische
Mathematik 8, 1966): two full-rate simulations a record, while every derivative still comes from the bins.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.repeats import merge_as
from discrepancy.data.series import SPEED, Series, bin_index
from discrepancy.fitting.levenberg import Fit, fit
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.outcome import SearchOutcome
from discrepancy.search.rough import settle_rough
from discrepancy.search.state import refit

FloatArray = NDArray[np.float64]

_ROUNDS = 2
_ITERATIONS = 4


def refine_full_rate(outcome: SearchOutcome, train: Sequence[Series]) -> SearchOutcome:
    """Return the outcome with its last model fitted to data that are corrected for binning, and these data.

    A law with a rough loss is fitted on finer samples instead: at another step other contacts are met.

    Args:
        outcome: found on records of which some samples were averaged into one.
        train: the records at full rate.
    """
    last = outcome.steps[-1]
    problem, found = outcome.problem, last.state.fit
    factor = problem.series[0].factor
    has_speed = any(channel.row == SPEED for channel in problem.series[0].channels)
    if factor <= 1 or not has_speed:
        return outcome
    if last.state.is_chaotic:
        return _settle_on_fine(outcome)
    full = merge_as(train, problem.series)
    corrected = problem
    for _ in range(_ROUNDS):
        corrected = correct_binning(problem, full, factor, found)
        found = fit(corrected, found.parameters, found.vector, found.starts, _ITERATIONS)
    steps = (*outcome.steps[:-1], replace(last, state=replace(last.state, fit=found)))
    return replace(outcome, steps=steps, problem=corrected)


def _settle_on_fine(outcome: SearchOutcome) -> SearchOutcome:
    """Return the outcome with all its models fitted to finer samples, the last one thoroughly."""
    fine, ranges = outcome.context.fine or outcome.problem, outcome.ranges
    *earlier, last = outcome.steps
    steps = [replace(step, state=refit(fine, step.state, ranges, _ITERATIONS)) for step in earlier]
    steps.append(replace(last, state=settle_rough(fine, last.state, ranges)))
    return replace(outcome, steps=tuple(steps), problem=fine)


def correct_binning(
    problem: SimulationProblem, fine: Sequence[Series], factor: int, at: Fit
) -> SimulationProblem:
    """Return the binned problem with what binning does to the simulation at a fitted point taken from its data."""
    outputs = problem.simulate(problem.prepare(at.vector), at.starts)
    series = []
    for one, full, output, start in zip(problem.series, fine, outputs, at.starts, strict=True):
        index, kept = bin_index(full, factor)
        single = replace(problem, series=(full,))
        begun = _fine_starts((one, full), kept, output, start)
        run = single.simulate(single.prepare(at.vector), (begun,))[0]
        channels = []
        for channel, raw in zip(one.channels, full.channels, strict=True):
            weight = raw.weight[index]
            total = np.maximum(weight.sum(axis=1), 1e-12)
            mean = (run[channel.row][index] * weight).sum(axis=1) / total
            channels.append(replace(channel, values=channel.values - mean + output[channel.row]))
        series.append(replace(one, channels=tuple(channels)))
    return replace(problem, series=tuple(series))


def _fine_starts(
    pair: tuple[Series, Series], kept: Sequence[int], output: FloatArray, start: FloatArray
) -> FloatArray:
    """Return the starting states half a bin earlier, where the full-rate windows begin, shape (m, k) as `start`.

    What this extrapolation misses is a change of the start, which every fit projects out.
    """
    binned, full = pair
    found = np.pad(full.starts, ((0, 0), (0, start.shape[1] - 2)))
    for m, ((a, _), window) in enumerate(zip(binned.edges, kept, strict=True)):
        ahead = binned.time_s[a] - full.time_s[full.edges[window][0]]
        slope = (output[SPEED, a + 1] - output[SPEED, a]) / (binned.time_s[a + 1] - binned.time_s[a])
        found[window] = start[m]
        found[window, :2] -= slope * ahead, start[m, 0] * ahead
    return found
