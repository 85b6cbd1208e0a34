"""Spectra of residuals, and the measured spectrum of the noise where records repeat each other."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from discrepancy.data.repeats import find_repeats
from discrepancy.data.series import Series
from discrepancy.evaluate import Curve
from discrepancy.report.pictures import Spectrum

FloatArray = NDArray[np.float64]

MERGED = " = "
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


def repeated_labels(series: Sequence[Series]) -> list[tuple[str, str]]:
    """Return the labels of whole records that repeat each other, of those too that were averaged into one."""
    merged = [pair for one in series for pair in pairwise(one.label.split(MERGED))]
    pairs = [pair for pair in find_repeats(series) if pair.first != pair.second]
    apart = [(series[pair.first].label, series[pair.second].label) for pair in pairs]
    return merged + [pair for pair in apart if MERGED not in pair[0] + pair[1]]


def noise_spectra(curves: Sequence[Curve], series: Sequence[Series]) -> dict[str, Spectrum]:
    """Return the noise of each output: the difference of the errors of two records with the same input, over sqrt(2).

    Args:
        curves: training curves of the last model at full rate.
        series: the training records as they were fitted; a merged one is labelled `a = b`.
    """
    found: dict[str, Spectrum] = {}
    known = {curve.label for curve in curves}
    for first, second in repeated_labels(series):
        if not {first, second} <= known:
            continue
        for one in (c for c in curves if c.label == first and c.name not in found):
            other = next(c for c in curves if c.label == second and c.name == one.name)
            n = min(one.time_s.size, other.time_s.size)
            left = (one.measured - one.simulated)[:n] - (other.measured - other.simulated)[:n]
            found[one.name] = spectrum(one.time_s[:n], left / np.sqrt(2.0))
    return found


def white_density(sigma: float, time_s: FloatArray) -> float:
    """Return the amplitude density that white noise of this standard deviation has."""
    return float(sigma * np.sqrt(2.0 * np.median(np.diff(time_s))))
