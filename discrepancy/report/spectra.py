"""Spectra of residuals, and the measured spectrum of the noise where records repeat each other."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from discrepancy.evaluate import Curve
from discrepancy.report.pictures import Spectrum

FloatArray = NDArray[np.float64]

LONGEST_SEGMENT = 16_384
CELLS = 160


def spectrum(time_s: FloatArray, values: FloatArray) -> Spectrum:
    """Return the amplitude density of a signal, averaged over even cells of the logarithm of the frequency."""
    step = float(np.median(np.diff(time_s)))
    segment = min(values.size, LONGEST_SEGMENT)
    frequency, power = welch(values, fs=1.0 / step, nperseg=segment)
    frequency, power = frequency[1:], power[1:]
    edges = np.geomspace(frequency[0] * 0.999, frequency[-1] * 1.001, CELLS + 1)
    place = np.searchsorted(edges, frequency) - 1
    count = np.bincount(place, minlength=CELLS)
    filled = count > 0
    middle = np.bincount(place, frequency, CELLS)[filled] / count[filled]
    mean = np.bincount(place, power, CELLS)[filled] / count[filled]
    return Spectrum(frequency=middle, density=np.sqrt(mean))


def noise_spectra(curves: Sequence[Curve], pairs: Sequence[tuple[str, str]]) -> dict[str, Spectrum]:
    """Return the noise of each output: the difference of the errors of two records with the same input, over sqrt(2).

    Args:
        curves: training curves of the last model.
        pairs: labels of records that repeat each other.
    """
    found: dict[str, Spectrum] = {}
    for first, second in pairs:
        for one in (c for c in curves if c.label == first and c.name not in found):
            other = next(c for c in curves if c.label == second and c.name == one.name)
            n = min(one.time_s.size, other.time_s.size)
            left = (one.measured - one.simulated)[:n] - (other.measured - other.simulated)[:n]
            found[one.name] = spectrum(one.time_s[:n], left / np.sqrt(2.0))
    return found


def white_density(sigma: float, time_s: FloatArray) -> float:
    """Return the amplitude density that white noise of this standard deviation has."""
    return float(sigma * np.sqrt(2.0 * np.median(np.diff(time_s))))
