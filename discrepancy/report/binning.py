"""Averages over cells of a variable, with intervals that hold for residuals that are correlated in time."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discrepancy.report.pictures import Binned

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

CELLS = 36
FEWEST = 25
MANY_BLOCKS = 4
_MEDIAN_OF_SQUARE = 0.455
"""Median of a squared standard normal number: outlying blocks must not widen every interval."""
_SIGMAS = 1.96


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Samples:
    """What is averaged; all of shape (n,).

    Attributes:
        per: y is described as coefficient * per in each cell; ones give plain means.
        block: number of the stretch of time that a sample belongs to.
    """

    x: FloatArray
    y: FloatArray
    per: FloatArray
    block: IntArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Cells:
    """Binned samples, and the edges that repeat the binning, shape (m + 1,)."""

    cells: Binned
    edges: FloatArray

    @property
    def x(self) -> FloatArray:
        """Middles of the cells."""
        return self.cells.x


def bin_samples(samples: Samples, edges: FloatArray | None = None) -> Cells:
    """Average in cells; cells with few samples are joined to their neighbours.

    The 95 % interval sums the residuals of a block before squaring them: neighbours in time do not count as
    independent.
    """
    chosen = cell_edges(samples.x) if edges is None else edges
    size = chosen.size - 1
    place = np.clip(np.searchsorted(chosen, samples.x, side="right") - 1, 0, size - 1)
    weight = np.bincount(place, samples.per**2, size)
    safe = np.where(weight > 0.0, weight, np.nan)
    mean = np.bincount(place, samples.y * samples.per, size) / safe
    # Empty cells are NaN: nothing is drawn there.
    rest = (samples.y - mean[place] * samples.per) * samples.per
    count = np.bincount(place, minlength=size).astype(np.float64)
    sums = np.zeros((int(samples.block.max(initial=-1)) + 1, size))  # none: a simulation that ran away
    np.add.at(sums, (samples.block, place), rest)
    shares = np.zeros_like(sums)
    np.add.at(shares, (samples.block, place), samples.per**2)
    # Never below what independent samples would give, nor below what blocks differ by elsewhere: the sum over a cell
    # that one block fills is zero, whatever the noise.
    variance = np.maximum((sums**2).sum(axis=0), np.bincount(place, rest**2, size)) / safe**2
    variance = np.maximum(variance, _block_variance(sums, shares) / np.maximum((shares > 0).sum(axis=0), 1))
    middle = np.bincount(place, samples.x, size) / np.maximum(count, 1.0)
    middle = np.where(count > 0, middle, 0.5 * (chosen[1:] + chosen[:-1]))
    cells = Binned(x=middle, mean=mean, error=_SIGMAS * np.sqrt(variance), count=count)
    return Cells(cells=cells, edges=chosen)


def _block_variance(sums: FloatArray, shares: FloatArray) -> float:
    """Return by how much the coefficient of one block differs from its cell's, squared, over cells of many blocks."""
    filled = shares > 0
    trusted = filled & (filled.sum(axis=0) >= MANY_BLOCKS)
    if not trusted.any():
        return 0.0
    return float(np.median((sums[trusted] / shares[trusted]) ** 2) / _MEDIAN_OF_SQUARE)


def cell_edges(x: FloatArray) -> FloatArray:
    """Return edges of even cells, zero being one of them where x changes its sign, none nearly empty."""
    low, high = (float(v) for v in np.quantile(x, [0.002, 0.998]))
    if not high > low:
        return np.array([low - 0.5, low + 0.5])
    edges = np.linspace(low, high, CELLS + 1)
    if low < 0.0 < high:
        edges = edges - edges[np.argmin(np.abs(edges))]
    count = np.histogram(x, edges)[0]
    kept = [float(edges[0])]
    gathered = 0
    for right, n in zip(edges[1:], count, strict=True):
        gathered += int(n)
        if gathered >= FEWEST or right == 0.0:
            kept.append(float(right))
            gathered = 0
    return np.array(kept) if len(kept) > 1 else np.array([low, high])
