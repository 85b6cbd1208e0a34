"""Make long signals small enough to draw without hiding a peak, and find the stretch worth looking at."""

import numpy as np
from numpy.typing import NDArray

from discrepancy.evaluate import Curve

FloatArray = NDArray[np.float64]

MOST_POINTS = 2000
STRETCH_SHARE = 0.08
SHORTEST_STRETCH = 200


def thin(time_s: FloatArray, values: FloatArray, most: int = MOST_POINTS) -> tuple[FloatArray, FloatArray]:
    """Return at most `most` points of a signal: least and largest value of each of `most / 2` stretches."""
    n = values.size
    if n <= most:
        return time_s, values
    width = -(-n // (most // 2))
    cells = -(-n // width)
    # The last stretch is filled with its last value: every sample lies in one.
    table = np.pad(values, (0, cells * width - n), mode="edge").reshape(cells, width)
    first = np.arange(cells) * width
    rows = np.unique(np.concatenate([first + table.argmin(axis=1), first + table.argmax(axis=1)]))
    return time_s[rows], values[rows]


def worst_stretch(curve: Curve) -> tuple[float, float]:
    """Return begin and end, s, of the stretch in which the simulation is furthest off."""
    error = (curve.measured - curve.simulated) ** 2 * (curve.weight > 0)
    n = error.size
    width = min(n, max(SHORTEST_STRETCH, int(STRETCH_SHARE * n)))
    total = np.concatenate([[0.0], np.cumsum(error)])
    begin = int(np.argmax(total[width:] - total[:-width]))
    return float(curve.time_s[begin]), float(curve.time_s[min(n - 1, begin + width)])


def within(curve: Curve, span: tuple[float, float]) -> slice:
    """Return the rows of a curve between two times."""
    first, last = np.searchsorted(curve.time_s, span)
    return slice(int(first), int(last) + 1)
