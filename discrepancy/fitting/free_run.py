"""Fit a long free run by its true residual, parameters and starting states together.

`levenberg.fit` projects starting states out of a linearised residual. Over a long free run of a position that fails:
at rest the sensitivity to the starting speed is all but that to the starting angle, and the two together explain what
no start can. Here every trial is simulated from its own starts, and only what it really leaves counts.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from discrepancy.data.series import SPEED, channel_row
from discrepancy.fitting.parameters import FitParameter
from discrepancy.fitting.problem import SimulationProblem, Starts

FloatArray = NDArray[np.float64]

MOST_WINDOWS = 20
"""Every window adds two numbers and two simulations a step; with more windows the linearised fit does well."""
_STEP = 1e-4
_EVALUATIONS = 60
_RUNAWAY = 1e6


@dataclass(frozen=True, slots=True, kw_only=True)
class FreeRun:
    """A fitted free run; `loss` is the sum of squares of the true residual in units of the noise variance."""

    vector: FloatArray
    starts: Starts
    loss: float


def fit_free_run(
    problem: SimulationProblem, parameters: Sequence[FitParameter], vector: FloatArray, starts: Starts
) -> FreeRun:
    """Fit `parameters` and the starting speed and angle of every window from `vector` and `starts`."""
    data = problem.measured()
    size = np.concatenate([_start_sizes(problem, start) for start in starts])
    count = len(parameters)

    def unpack(x: FloatArray) -> tuple[FloatArray, Starts]:
        moved = vector.copy()
        for z, parameter in zip(x[:count], parameters, strict=True):
            moved[parameter.slot] = parameter.decode(float(z))
        changes, at, found = x[count:] * size, 0, []
        for start in starts:
            found.append(start + changes[at : at + start.size].reshape(start.shape))
            at += start.size
        return problem.prepare(moved), tuple(found)

    def residual(x: FloatArray) -> FloatArray:
        left = problem.flatten(problem.simulate(*unpack(x))) - data
        return np.clip(np.nan_to_num(left, nan=_RUNAWAY), -_RUNAWAY, _RUNAWAY)

    def jacobian(x: FloatArray) -> FloatArray:
        at, steps = residual(x), _STEP * np.eye(x.size)
        return np.stack([(residual(x + step) - at) / _STEP for step in steps], axis=1)

    first = np.array([*(p.encode(float(vector[p.slot])) for p in parameters), *np.zeros(size.size)])
    found = least_squares(residual, first, jac=jacobian, x_scale="jac", max_nfev=_EVALUATIONS)
    moved, begun = unpack(found.x)
    return FreeRun(vector=moved, starts=begun, loss=float(found.fun @ found.fun))


def best_free_run(
    problem: SimulationProblem, parameters: Sequence[FitParameter], vector: FloatArray
) -> FreeRun:
    """Return the better of the fits that begin at the measured starting speeds and at rest."""
    starts = problem.initial_starts()
    at_rest = tuple(start * np.array([0.0, 1.0]) for start in starts)
    return min(
        (fit_free_run(problem, parameters, vector, one) for one in (starts, at_rest)),
        key=lambda one: one.loss,
    )


def _start_sizes(problem: SimulationProblem, start: FloatArray) -> FloatArray:
    """Return typical changes of the starting states of one record, flattened as they are."""
    one = problem.series[0]
    travel = max(float(np.ptp(one.angle)) if one.angle.size else 0.0, 1e-9)
    speed = next((c.values for c in one.channels if channel_row(c.name) == SPEED), None)
    top = (
        float(np.ptp(speed)) if speed is not None else travel / max(one.step, 0.1 * float(np.ptp(one.time_s)))
    )
    return np.tile([max(top, 1e-9), travel], len(start))
