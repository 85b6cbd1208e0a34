"""Fit a law whose loss is rough: play between motor and load.

Each contact begins a little earlier or later when a parameter moves, so the loss of a free run has a hollow for every
number of bounces, and a descent ends in the nearest one: a contact three times too soft, with a torque constant that
makes up for it. Four things lead out of that. Starts are many and are only simulated, not fitted. The first fits
follow the slow part of the motion, measured and simulated speed smoothed alike, which hardly knows single bounces; the
corner then rises step by step (a continuation, as in E. L. Allgower, K. Georg, Numerical Continuation Methods, 1990).
The samples are finer than those of other laws, since the speed of a free motor bends within a few milliseconds. And the
accepted law is sought further by random steps in the shape of the valley (the inverse of the information matrix), each
followed by a descent: (1+1) evolution with the fifth rule (I. Rechenberg, 1973).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.series import SPEED, Series
from discrepancy.effects.spec import Ranges
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.levenberg import Fit, fit, glance
from discrepancy.fitting.parameters import SMOOTHING, SMOOTHING_RANGE_S, FitParameter
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.state import (
    SCAN_KEEP,
    State,
    misfit,
    nearest_vectors,
    parameters_of,
    plate_vectors,
    refit,
    starting_vectors,
    without,
)
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.smoothing import smooth_speed

FloatArray = NDArray[np.float64]

_SLOW_S, _MIDDLE_S = 0.08, 0.04
"""Time constants of the smoothing, s: corners of 2 and 4 Hz."""
_SMOOTHEST_ORDER = 3.0
_FOLLOWED = 3
"""So many of the simulated starts are fitted."""
_DESCENT = 10
_ROUNDS, _STEPS, _SHORT = 5, 60, 6
_ENOUGH = 0.02
"""The random search ends when a round gains less than this part of the loss."""
_FARTHEST = 0.3
_RADIUS = (1e-4, 0.3, 3.0)
"""Smallest, first and largest size of a random step: the part of the loss that it would add in a smooth valley."""


def scan_rough(problem: SimulationProblem, state: State, name: str, ranges: Ranges) -> list[State]:
    """Simulate every start of one more effect, fit the slow motion from the best, and return those, best first.

    Their losses are the state's own, less what the slow motion gains: the fast one gains more or nothing.
    """
    effect = EFFECTS[name]
    bare = without(state, [other for other in state.added if other in effect.contains])
    parameters = parameters_of(bare.base, bare.given, (*bare.added, name), ranges)
    slow = smoothed(problem, _SLOW_S)
    # Play drags the recalibrated joint far away: begin at the nameplate too.
    vectors = starting_vectors(state, bare, effect, ranges) + plate_vectors(state, bare, effect, ranges)
    fits = [
        _fit_smoothed(slow, parameters, replace(bare.fit, vector=vector), _SLOW_S)
        for vector in _best_vectors(slow, vectors, bare.fit)
    ]
    fits.sort(key=lambda one: one.loss)
    base = _fit_smoothed(slow, state.fit.parameters, state.fit, _SLOW_S)
    return [
        replace(
            bare, added=(*bare.added, name), nameplate=None,
            fit=replace(one, loss=state.fit.loss - max(0.0, base.loss - one.loss)),
        )
        for one in fits[:SCAN_KEEP]
    ]  # fmt: skip


def polish_rough(
    problems: tuple[SimulationProblem, SimulationProblem], scanned: Sequence[State], ranges: Ranges
) -> State:
    """Follow the best of the scanned starts to the whole motion.

    Args:
        problems: fine samples, on which the fit is made, and those on which all laws are compared.
        scanned: what `scan_rough` returned.
        ranges: sizes of the signals.
    """
    fine, coarse = problems
    one = scanned[0]
    parameters = parameters_of(one.base, one.given, one.added, ranges)
    half = _fit_smoothed(smoothed(fine, _MIDDLE_S), parameters, one.fit, _MIDDLE_S)
    whole = fit(fine, parameters, _with_smoothing(fine, half), half.starts, _DESCENT)
    return refit(coarse, replace(one, fit=whole), ranges, _SHORT)


def settle_rough(problem: SimulationProblem, state: State, ranges: Ranges) -> State:
    """Return an accepted model fitted on fine samples by random steps and descents in turn; the same on every call."""
    generator = np.random.default_rng(0)
    best = refit(problem, state, ranges, _DESCENT)
    for _ in range(_ROUNDS):
        vector = _wander(problem, best.fit, generator)
        trial = fit(problem, best.fit.parameters, vector, best.fit.starts, _SHORT)
        gain = best.fit.loss - trial.loss
        if gain > 0.0:
            best = replace(best, fit=trial)
        if gain < _ENOUGH * best.fit.loss:
            break
    return best


def smoothed(problem: SimulationProblem, time_constant: float) -> SimulationProblem:
    """Return the problem with its measured speeds smoothed further."""
    return replace(problem, series=tuple(_smooth(one, time_constant) for one in problem.series))


def _smooth(one: Series, time_constant: float) -> Series:
    channels = []
    for channel in one.channels:
        values = channel.values.copy()
        if channel.row == SPEED:
            smooth_speed(values, one.windows, one.step, time_constant, _SMOOTHEST_ORDER)
        channels.append(replace(channel, values=values))
    return replace(one, channels=tuple(channels))


def _fit_smoothed(
    problem: SimulationProblem, parameters: Sequence[FitParameter], at: Fit, time_constant: float
) -> Fit:
    """Fit to smoothed speeds, for values and loss; the smoothing that the fitted point had comes back afterwards."""
    vector = at.vector.copy()
    own = vector[s.OUTPUT_SMOOTHING], vector[s.SMOOTHING_ORDER]
    if own[0] > 0.0:
        vector[s.OUTPUT_SMOOTHING], vector[s.SMOOTHING_ORDER] = time_constant, _SMOOTHEST_ORDER
    moved = [one for one in parameters if one.name != SMOOTHING]
    found = glance(problem, moved, (vector, at.starts), _DESCENT, None)
    found.vector[s.OUTPUT_SMOOTHING], found.vector[s.SMOOTHING_ORDER] = own
    return found


def _with_smoothing(problem: SimulationProblem, at: Fit) -> FloatArray:
    """Return the vector with the smoothing of the speed that suits it: what was there was fitted to a gap."""
    if at.vector[s.OUTPUT_SMOOTHING] <= 0.0:
        return at.vector
    lowest, highest = SMOOTHING_RANGE_S
    data, trials = problem.measured(), []
    for constant in np.geomspace(30.0 * lowest, highest, 6):
        for order in (2.0, 3.0):
            trial = at.vector.copy()
            trial[s.OUTPUT_SMOOTHING], trial[s.SMOOTHING_ORDER] = constant, order
            trials.append(trial)
    return min(trials, key=lambda trial: misfit(problem, data, trial, at.starts))


def _best_vectors(problem: SimulationProblem, vectors: Sequence[FloatArray], at: Fit) -> list[FloatArray]:
    """Return the starts nearest to the smoothed records, simulated with the same smoothing; the rest of each stays."""
    slow = []
    for vector in vectors:
        slow.append(vector.copy())
        if vector[s.OUTPUT_SMOOTHING] > 0.0:
            slow[-1][s.OUTPUT_SMOOTHING], slow[-1][s.SMOOTHING_ORDER] = _SLOW_S, _SMOOTHEST_ORDER
    return nearest_vectors(problem, slow, at)[:_FOLLOWED]


def _wander(problem: SimulationProblem, at: Fit, generator: np.random.Generator) -> FloatArray:
    """Return the best vector of a walk of random steps in the shape of the valley."""
    power, turned = np.linalg.eigh(at.normal())
    width = 1.0 / np.sqrt(np.maximum(power, 1e-8 * power[-1]))
    data, vector = problem.measured(), at.vector
    least = misfit(problem, data, vector, at.starts)
    smallest, radius, largest = _RADIUS
    for _ in range(_STEPS):
        step = turned @ (generator.standard_normal(width.size) * width)
        step *= np.sqrt(radius * least / width.size)
        trial = vector.copy()
        for parameter, move in zip(at.parameters, np.clip(step, -_FARTHEST, _FARTHEST), strict=True):
            z = parameter.encode(float(vector[parameter.slot])) + float(move)
            trial[parameter.slot] = parameter.decode(z)
        loss = misfit(problem, data, problem.prepare(trial), at.starts)
        if loss < least:
            vector, least, radius = trial, loss, min(2.0 * radius, largest)
        else:
            # Five failures undo the gain of one success.
            radius *= 0.5**0.2
        if radius < smallest:
            radius = _RADIUS[1]
    return problem.prepare(vector)
