"""Figures of merit of a predicted series."""

from dataclasses import dataclass

import numpy as np

from estimators.dataset import Vector


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """How well a series follows the measured one.

    Attributes:
        n: samples compared.
        rmse: root mean square error, in the unit of y.
        r2: coefficient of determination; NaN if y does not move or the prediction left the range of numbers.
        r2_adjusted: the same, adjusted for the number of parameters (paper, eq. 26).
    """

    n: int
    rmse: float
    r2: float
    r2_adjusted: float


def determine_r2(y: Vector, predicted: Vector) -> float:
    """Return 1 - sum (y - predicted)^2 / sum (y - mean(y))^2 (paper, eq. 26, first line).

    The paper prints an index on the mean; it is the mean over all samples.
    """
    total = float(np.sum((y - y.mean()) ** 2))
    with np.errstate(all="ignore"):
        missed = float(np.sum((y - predicted) ** 2))
    if total == 0.0 or not np.isfinite(missed):
        return float("nan")
    return 1.0 - missed / total


def adjust_r2(r2: float, n: int, p: int) -> float:
    """Return 1 - (n - 1) / (n - (p + 1)) (1 - r2) (paper, eq. 26, second line).

    Args:
        r2: coefficient of determination.
        n: observations.
        p: parameters.

    Returns:
        Adjusted R2, NaN when there are not more observations than parameters plus one.
    """
    if n <= p + 1:
        return float("nan")
    return 1.0 - (n - 1) / (n - (p + 1)) * (1.0 - r2)


def score_series(y: Vector, predicted: Vector, p: int, rows: np.ndarray) -> Score:
    """Score a predicted series on the given samples.

    Args:
        y: measured output, shape (N,).
        predicted: prediction, shape (N,).
        p: number of parameters of the model.
        rows: indices of the samples that count.
    """
    measured, guess = y[rows], predicted[rows]
    with np.errstate(all="ignore"):
        rmse = float(np.sqrt(np.mean((measured - guess) ** 2))) if measured.size else float("nan")
    r2 = determine_r2(measured, guess) if measured.size else float("nan")
    return Score(n=int(measured.size), rmse=rmse, r2=r2, r2_adjusted=adjust_r2(r2, int(measured.size), p))
