"""Batch least squares: the reference that the recursive estimators must reproduce."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.dataset import Dataset, Vector
from estimators.regressors import Regression, build_regression
from estimators.settings import IdentifyOptions


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BatchEstimate:
    """Parameters from all samples at once.

    Attributes:
        theta: parameters, shape (n,).
        covariance: of theta, shape (n, n).
        noise_variance: of the equation error (`iv`: of the noise on the output), unit of y squared.
        notes: sentences for the reader about how the estimate came about; empty if all went well.
    """

    theta: Vector
    covariance: NDArray[np.float64]
    noise_variance: float
    notes: tuple[str, ...] = ()


def solve_least_squares(regression: Regression) -> BatchEstimate:
    """Minimise sum (y - phi' theta)^2 by a singular value decomposition of the scaled regressors.

    theta = (Phi' Phi)^-1 Phi' y, covariance sigma2 (Phi' Phi)^-1 with sigma2 = RSS / (N - n). Columns are
    scaled to unit length first, so units do not matter. Directions that the data do not determine at all get
    the solution of least length and an infinite variance. Biased when the output is noisy (use `iv`).
    """
    phi, y = regression.phi, regression.y
    length = np.linalg.norm(phi, axis=0)
    length[length == 0.0] = 1.0
    left, singular, right = np.linalg.svd(phi / length, full_matrices=False)
    known = singular > singular[0] * max(phi.shape) * np.finfo(float).eps
    inverse = np.where(known, 1.0 / np.where(known, singular, 1.0), 0.0)
    theta = (right.T @ (inverse * (left.T @ y))) / length
    freedom = max(y.size - int(known.sum()), 1)
    noise_variance = float(np.sum((y - phi @ theta) ** 2) / freedom)
    spread = right.T * inverse
    covariance = noise_variance * (spread @ spread.T) / np.outer(length, length)
    if known.all():
        return BatchEstimate(theta=theta, covariance=covariance, noise_variance=noise_variance)
    loose = np.any(np.abs(right[~known]) > 1e-6, axis=0)
    covariance[loose, :] = covariance[:, loose] = np.inf
    note = "the data do not determine all parameters; see the excitation report"
    return BatchEstimate(theta=theta, covariance=covariance, noise_variance=noise_variance, notes=(note,))


def fit_least_squares(dataset: Dataset, options: IdentifyOptions) -> BatchEstimate:
    """Estimate from a data set by batch least squares."""
    return solve_least_squares(build_regression(dataset, options.structure))
