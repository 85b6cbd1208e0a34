"""How far fitted values may lie from the true ones: noise, what the recording leaves open, and the model's form.

Noise: block sandwich, which holds for coloured noise too (W. K. Newey, K. D. West, Econometrica 55, 1987, with blocks
in place of lags). What the making of the recording leaves open (timing of the input, smoothing of the speed) enters
with the range that it can have: without it a delay would seem as well known as the sum of both. The instant within a
sample at which an output is read is nobody's parameter, nor is the formula by which a program realises a lag: what
these would move adds as a rectangular error. Form: by how much the values move when the frequencies are weighted by
the noise instead of equally (J. A. Hausman, Econometrica 46, 1978: two estimators that agree where the model is right),
what free curves beside the laws would do that the noise leaves open (`model_error`), and how far the values lie from
those of other forms of the same law (an exponent, for example) that fit about as well (S. T. Buckland et al.,
Biometrics 53, 1997). Of a chaotic motion none of this can be linearised: there the estimates of stretches tell
(`stretches`).
"""

from collections.abc import Collection
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from discrepancy.effects.spec import Kind, Port, Ranges
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.levenberg import Fit, start_projector
from discrepancy.fitting.parameters import TIMING, FitParameter
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.bench import Bench
from discrepancy.search.judge import BLOCK_S
from discrepancy.search.model_error import law_variances, settle
from discrepancy.search.state import fitted_forms
from discrepancy.search.stretches import stretch_variances
from discrepancy.simulation import slots as s

FloatArray = NDArray[np.float64]


def robust_covariance(
    problem: SimulationProblem, fit: Fit, held: Collection[str] = frozenset()
) -> FloatArray:
    """Return the covariance of the fitted values under coloured noise, SI units, shape (p, p).

    Args:
        problem: with the noise weights of the fit.
        fit: the fitted point.
        held: names of parameters taken as known; their rows and columns are zero.
    """
    p = len(fit.parameters)
    free = np.array([q.name not in held for q in fit.parameters], dtype=bool)
    covariance = np.zeros((p, p))
    if not free.any():
        return covariance
    J, r = fit.jacobian[:, free], fit.residual
    scores = np.stack(
        [
            sum((J[part].T @ r[part] for part in parts), np.zeros(J.shape[1]))
            for parts in problem.blocks(BLOCK_S)
        ]
    )
    unit = fit.loss / max(1, fit.residual.size - J.shape[1])
    known = np.diag(_known_before(fit)[free] * unit)
    inverse = _inverse(J.T @ J + known)
    meat = scores.T @ scores * len(scores) / max(1, len(scores) - J.shape[1]) + known * unit
    classical = np.diag(inverse) * unit
    robust = inverse @ meat @ inverse
    # Few blocks make a noisy sandwich: never below the classical covariance.
    scale = np.sqrt(np.maximum(1.0, classical / np.maximum(np.diag(robust), 1e-300)))
    scale *= _slopes(fit)[free]
    covariance[np.ix_(free, free)] = robust * np.outer(scale, scale)
    return covariance


def standard_errors(problem: SimulationProblem, fit: Fit, rest: tuple[Bench | None, Ranges]) -> FloatArray:
    """Return the standard errors of the fitted values, SI units, shape (p,).

    Args:
        problem: with white noise weights.
        fit: the fitted point.
        rest: the same model under both noise models, None where a torque balance is judged; sizes of the signals.
    """
    squares = np.maximum(0.0, np.diag(robust_covariance(problem, fit)))
    bench, ranges = rest
    if bench is None or not squares.size:
        return np.asarray(np.sqrt(squares))
    if bench.state.is_chaotic:
        squares = squares + stretch_variances(problem, fit)
    else:
        squares = squares + _form_errors(problem, fit) + form_variances(bench, ranges)
    return np.asarray(np.sqrt(squares + _reading_instants(problem, fit) + _realisations(problem, fit)))


def _form_errors(problem: SimulationProblem, fit: Fit) -> FloatArray:
    """Return what an error of the laws' form may move the fitted values by, squared, shape (p,).

    Two parts: how far they move towards the estimate that weights frequencies by the noise, and what curves over each
    variable that this noise leaves open would do.
    """
    settled = settle(problem, fit)
    known = np.diag(_known_before(fit))
    J, sharp = fit.jacobian, settled.fit.jacobian
    inverse = _inverse(J.T @ J + known * fit.loss / max(1, fit.residual.size - J.shape[1]))
    step = _inverse(sharp.T @ sharp + known * settled.unit) @ (sharp.T @ settled.fit.residual)
    laws = law_variances(problem, fit, settled, inverse)
    return np.asarray((step**2 + laws) * _slopes(fit) ** 2)


def _realisations(problem: SimulationProblem, fit: Fit) -> FloatArray:
    """Return the variances of time constants that a program may realise, SI units, shape (p,).

    A filter of the time constant T in steps of h acts as one of T - h/2 by the forward difference, of T by the exact
    hold and of T + h/2 by the backward difference (to first order): nothing in a recording says which one was meant.
    A delay needs no formula, and how the input is timed is a parameter of its own.
    """
    step = problem.series[0].original_step
    return np.array([step**2 / 12.0 if _is_realised(q) else 0.0 for q in fit.parameters])


def _is_realised(parameter: FitParameter) -> bool:
    effect = EFFECTS.get(parameter.owner)
    if effect is None or effect.port is Port.TORQUE or parameter.slot == s.DELAY:
        return False
    return any(p.name == parameter.name and p.kind is Kind.TIME for p in effect.parameters)


def form_variances(bench: Bench, ranges: Ranges) -> FloatArray:
    """Return how far the fitted values of other forms of the added laws lie, squared, by likelihood, shape (p,)."""
    present = replace(bench.state, fit=bench.sharp)
    total = np.zeros(len(bench.sharp.parameters))
    for name in present.added:
        forms = fitted_forms(bench.sharp_problem, present, name, ranges)
        if not forms:
            continue
        losses = np.array([one.fit.loss for one in forms])
        weights = np.exp(-0.5 * (losses - losses.min()) / bench.unit)
        apart = np.stack([one.fit.values - bench.sharp.values for one in forms])
        total += weights @ apart**2 / weights.sum()
    return total


def _reading_instants(problem: SimulationProblem, fit: Fit) -> FloatArray:
    """Return the variances of the fitted values if each output is read anywhere within its sample, shape (p,)."""
    total = np.zeros(len(fit.parameters))
    if not any(q.name == TIMING for q in fit.parameters):
        return total  # the model file says how the recording was made
    outputs = problem.simulate(fit.vector, fit.starts)
    unit = fit.loss / max(1, fit.residual.size - len(fit.parameters))
    inverse = _inverse(fit.normal() + np.diag(_known_before(fit) * unit))
    projector = start_projector(problem, fit)
    for row in {channel.row for channel in problem.series[0].channels}:
        moved = []
        for one, output in zip(problem.series, outputs, strict=True):
            late = np.zeros_like(output)
            late[row] = np.gradient(output[row], one.time_s) * one.original_step / np.sqrt(12.0)
            moved.append(late)
        column = projector.project(problem.flatten(moved))
        total += (inverse @ (fit.jacobian.T @ column) * _slopes(fit)) ** 2
    return total


def _known_before(fit: Fit) -> FloatArray:
    return np.array([q.known_before(float(fit.vector[q.slot])) for q in fit.parameters])


def _slopes(fit: Fit) -> FloatArray:
    return np.array([q.slope(float(fit.vector[q.slot])) for q in fit.parameters])


def _inverse(normal: FloatArray) -> FloatArray:
    """Return the pseudo-inverse of an information matrix whose rows may differ by many orders of magnitude."""
    size = np.sqrt(np.diag(normal)) + 1e-12
    return np.asarray(np.linalg.pinv(normal / np.outer(size, size), rcond=1e-12) / np.outer(size, size))
