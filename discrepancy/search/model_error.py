"""What a model's own error of form may do to its fitted values: laws that are nearly right, and by how much not.

A fitted law is never quite the true one, and what it lacks moves the fitted values without showing in the residual:
least squares make the residual orthogonal to every parameter. What shows is the part of the error that no parameter can
take up. Here the error is a free curve over one variable after another (torque over speed, angle, current,
acceleration, time; current and sensors likewise) with independent heights of an unknown variance t^2: a random effect
(D. A. Harville, J. Am. Stat. Assoc. 72, 1977; for computer models M. C. Kennedy, A. O'Hagan, J. R. Stat. Soc. B 63,
2001). The residual, freed of the parameters, says how large t^2 is; each height then moves each value by a known
amount.

With s^2 the sampling variance of a height, the prior of t^2 makes s^2 / (s^2 + t^2) uniform between 0 and 1 (M. J.
Daniels, Can. J. Stat. 27, 1999): it is proper however few heights there are. It has no scale, and of a curve that the
records hardly show the residual says nothing: the mean of t^2 is cut off at a part of the motion itself.

The residual is judged in its own noise, without the ends of the records: a smoothed speed errs there several times more
than elsewhere, and a prediction-error filter has no past to predict from.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal.windows import tukey

from discrepancy.fitting.levenberg import Fit, fit, start_projector
from discrepancy.fitting.noise import fit_whitener, innovation_sigma
from discrepancy.fitting.problem import Noise, SimulationProblem
from discrepancy.search.curves import flat_columns, law_responses
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.smoothing import REACH

FloatArray = NDArray[np.float64]

_GRID = 240
_VISIBLE = 1e-9
_TAPER = 0.1
"""The noise falls by six decades towards the highest frequency: without a taper the ends of the record hide that."""
_WHITENER = 6
LARGEST = 0.02
"""A curve that the laws lack moves the outputs by at most this part of what they are (rms),"""
SHOWN = 3.0
"""or by so many times what the model leaves of them, if that is more."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Settled:
    """A model in the noise that it leaves, without the ends of the records.

    Attributes:
        problem: with that noise.
        fit: residual and Jacobian there, at the values of the original fit.
        unit: variance of a whitened sample.
    """

    problem: SimulationProblem
    fit: Fit
    unit: float


def settle(problem: SimulationProblem, at: Fit) -> Settled:
    """Return a fitted model in the noise that it leaves."""
    edge = _edge(problem, at)
    outputs = problem.simulate(at.vector, at.starts)
    sigma, whitener = {}, {}
    for c, channel in enumerate(problem.series[0].channels):
        left = []
        for one, output in zip(problem.series, outputs, strict=True):
            own = one.channels[c]
            part = (own.values - output[own.row]) * own.weight
            part = part[edge : part.size - edge]
            left.append(part - part.mean())
        whitener[channel.name] = fit_whitener([part * tukey(part.size, _TAPER) for part in left], _WHITENER)
        sigma[channel.name] = max(innovation_sigma(left, whitener[channel.name]), 1e-12)
    sharp = replace(problem, noise=Noise(sigma=sigma, whitener=whitener), edge=edge)
    there = fit(sharp, at.parameters, at.vector, at.starts, 0)
    count = int(np.count_nonzero(there.residual))
    return Settled(problem=sharp, fit=there, unit=max(there.loss / max(1, count), 1e-300))


def _edge(problem: SimulationProblem, at: Fit) -> int:
    """Return how many samples at either end of a record are left out."""
    reach = int(REACH * float(at.vector[s.OUTPUT_SMOOTHING]) / problem.series[0].step) + 1 + _WHITENER
    return min(reach, min(one.n for one in problem.series) // 8)


def law_variances(problem: SimulationProblem, at: Fit, settled: Settled, inverse: FloatArray) -> FloatArray:
    """Return the variances of the fitted coordinates that errors of form leave, shape (p,).

    Args:
        problem: the problem that was fitted.
        at: the fitted point.
        settled: the same from `settle`.
        inverse: inverse of the information matrix of that fit, scaled coordinates, shape (p, p).
    """
    outputs = problem.simulate(at.vector, at.starts)
    moved, shown = start_projector(problem, at), start_projector(settled.problem, settled.fit)
    own, _ = np.linalg.qr(_scaled(settled.fit.jacobian))
    left = settled.fit.residual - own @ (own.T @ settled.fit.residual)
    size = float(np.linalg.norm(problem.flatten(outputs)))
    total, largest = np.zeros(len(at.parameters)), max((LARGEST * size) ** 2, SHOWN**2 * at.loss)
    for responses in law_responses(problem, at.vector, outputs):
        heights = moved.project(flat_columns(problem, responses))
        sharp = shown.project(flat_columns(settled.problem, responses))
        cap = largest / max(float(np.sum(heights**2)), 1e-300)
        square = _mean_square(sharp - own @ (own.T @ sharp), left, (settled.unit, cap))
        total += square * np.sum((inverse @ (at.jacobian.T @ heights)) ** 2, axis=1)
    return total


def _mean_square(columns: FloatArray, left: FloatArray, limits: tuple[float, float]) -> float:
    """Return the posterior mean of the variance of the heights whose effect on the residual `columns` holds.

    Args:
        columns: effect of a unit height, shape (N, k).
        left: the residual, shape (N,).
        limits: variance of its noise, and the largest variance that the heights may have.
    """
    unit, largest = limits
    power, turned = np.linalg.eigh(columns.T @ columns / unit)
    seen = power > _VISIBLE * power[-1]
    if power[-1] <= 0.0 or not seen.any():
        return 0.0
    power, found = power[seen], turned[:, seen].T @ (columns.T @ left) / unit
    sampling = 1.0 / float(np.mean(power))
    squares = sampling * np.geomspace(1e-4, 1e8, _GRID)
    prior = sampling / (sampling + squares) ** 2 * np.gradient(squares)
    grown = squares[:, None] * power
    log = 0.5 * np.sum(squares[:, None] * found**2 / (1.0 + grown) - np.log1p(grown), axis=1)
    weights = prior * np.exp(log - log.max())
    return min(largest, float(weights @ squares / weights.sum()))


def _scaled(columns: FloatArray) -> FloatArray:
    return np.asarray(columns / (np.linalg.norm(columns, axis=0) + 1e-300))
