"""What is noise: from repeats where there are any, else from the high band, else from what the best model leaves.

An autoregressive model of the residual of a wrong model would take the missing effect for noise (it acts as a
differentiator), so a whitening filter is fitted only to differences of repeats or to the residual of the best
candidate.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz

from discrepancy.data.repeats import Pair
from discrepancy.data.series import Series

FloatArray = NDArray[np.float64]

_ORDER = 6


def repeat_noise(residuals: Sequence[Sequence[FloatArray]], pairs: Sequence[Pair]) -> list[list[FloatArray]]:
    """Return noise realisations by channel: differences of the residuals of repeats over sqrt(2).

    Args:
        residuals: [record][channel] arrays. Differences of residuals, not of outputs: what the noise of the measured
            input does to the simulation then counts as noise too.
        pairs: stretches that repeat each other.
    """
    channels = len(residuals[0])
    return [
        [pair.difference([record[c] for record in residuals]) / np.sqrt(2.0) for pair in pairs]
        for c in range(channels)
    ]


def high_band_sigma(residuals: Sequence[FloatArray]) -> float:
    """Return the noise level that third differences show, robust against single events."""
    # Third differences remove anything smooth; their gain for white noise is 1 + 9 + 9 + 1.
    differences = np.concatenate([np.diff(r, n=3) for r in residuals])
    central = np.sort(np.abs(differences))[: int(0.9 * differences.size)]
    # Mean square of the central 90 % of a normal variable is 0.6161 of its variance... measured by its own quantiles.
    return float(np.sqrt(np.mean(central**2) / _CENTRAL_90 / 20.0))


_CENTRAL_90 = 1.0 - 2.0 * 1.6448536 * 0.1031356 / 0.9
"""Variance of a standard normal variable cut at +-1.645 (its central 90 %)."""


def fit_whitener(noise: Sequence[FloatArray], order: int = _ORDER) -> FloatArray:
    """Return the prediction-error filter of a noise realisation (Yule-Walker), shape (order + 1,)."""
    correlation = np.zeros(order + 1)
    for part in noise:
        centred = part - part.mean()
        for lag in range(order + 1):
            correlation[lag] += float(centred[lag:] @ centred[: centred.size - lag])
    if correlation[0] <= 0.0:
        return np.array([1.0])
    correlation[0] *= 1.0 + 1e-6
    coefficients = solve_toeplitz(correlation[:-1], correlation[1:])
    return np.concatenate([[1.0], -np.asarray(coefficients)])


def innovation_sigma(noise: Sequence[FloatArray], whitener: FloatArray) -> float:
    """Return the standard deviation of whitened noise."""
    whitened = np.concatenate([np.convolve(part, whitener, mode="valid") for part in noise])
    return float(np.std(whitened))


def sigma_or_floor(sigma: float, values: FloatArray) -> float:
    """Return a noise level that is never zero: clean simulations still need a scale."""
    return max(sigma, 1e-6 * float(np.std(values)), 1e-15)


def sample_sigma(
    series: Sequence[Series], channel: int, factor: int, binned: float, pairs: Sequence[Pair]
) -> float:
    """Return the noise of one sample at full rate: that of a bin, and what varies inside the bins.

    Args:
        series: records at full rate.
        channel: index of the output.
        factor: samples in a bin.
        binned: standard deviation of a bin.
        pairs: repeats; their differences show the noise inside the bins without any signal.
    """
    if factor <= 1:
        return binned
    values = [one.channels[channel].values for one in series]
    if not pairs:
        inside = high_band_sigma(values) ** 2 * (1.0 - 1.0 / factor)
        return float(np.sqrt(binned**2 + inside))
    variances = []
    for pair in pairs:
        apart = pair.difference(values, factor)
        cells = apart[: apart.size // factor * factor].reshape(-1, factor)
        variances.append(float(np.mean(cells.var(axis=1))) / 2.0)
    return float(np.sqrt(binned**2 + np.mean(variances)))


def mean_sigma(levels: Mapping[str, float]) -> float:
    """Return the root mean square of several levels."""
    return float(np.sqrt(np.mean(np.square(list(levels.values())))))
