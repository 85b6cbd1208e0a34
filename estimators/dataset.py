"""Input and output samples of one experiment on a uniform time axis, with its holes.

This file knows nothing of models; regressors are built in `estimators.regressors`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Dataset:
    """Samples of one experiment.

    Attributes:
        u: input, shape (N,), in its own unit (A for the joint).
        y: output, shape (N,), in its own unit (rad/s for the joint).
        sample_time_s: time between samples of one segment.
        starts: index of the first sample of each segment, increasing, the first one 0. Samples of two
            segments are not neighbours in time, so no regressor may reach across a start.
    """

    u: Vector
    y: Vector
    sample_time_s: float
    starts: tuple[int, ...] = (0,)

    def __post_init__(self) -> None:
        """Take private copies of the arrays and check everything once, here.

        Raises:
            ValueError: If a shape, a value or a segment start is not usable.
        """
        for name in ("u", "y"):
            values = np.array(getattr(self, name), dtype=np.float64, order="C")
            if values.ndim != 1:
                raise ValueError(f"{name} has shape {values.shape}; give one value per sample, shape (N,)")
            bad = np.flatnonzero(~np.isfinite(values))
            if bad.size:
                raise ValueError(
                    f"{name}[{bad[0]}]={values[bad[0]]} is not finite ({bad.size} of {values.size} samples); "
                    "use split_at_holes() to start a new segment after each hole"
                )
            object.__setattr__(self, name, values)
        if self.u.size != self.y.size:
            raise ValueError(f"u has {self.u.size} samples and y has {self.y.size}; they must be equal")
        if not (np.isfinite(self.sample_time_s) and self.sample_time_s > 0):
            raise ValueError(f"sample_time_s={self.sample_time_s} must be a positive number of seconds")
        starts = tuple(int(start) for start in self.starts)
        object.__setattr__(self, "starts", starts)
        increasing = all(left < right for left, right in zip(starts, starts[1:], strict=False))
        if not starts or starts[0] != 0 or not increasing or starts[-1] >= max(self.u.size, 1):
            raise ValueError(
                f"starts={starts} must begin with 0, increase, and stay below {self.u.size} samples"
            )

    @property
    def n(self) -> int:
        """Number of samples."""
        return int(self.u.size)

    @property
    def segments(self) -> tuple[slice, ...]:
        """One slice per stretch without holes."""
        stops = (*self.starts[1:], self.n)
        return tuple(slice(start, stop) for start, stop in zip(self.starts, stops, strict=True))

    def take(self, first: int, stop: int) -> "Dataset":
        """Return samples first..stop-1 with the segment starts that fall inside."""
        inner = tuple(start - first for start in self.starts if first < start < stop)
        return Dataset(
            u=self.u[first:stop], y=self.y[first:stop], sample_time_s=self.sample_time_s, starts=(0, *inner)
        )


def split_at_holes(
    u: ArrayLike, y: ArrayLike, sample_time_s: float, starts: tuple[int, ...] = (0,)
) -> Dataset:
    """Drop samples in which u or y is not finite and begin a new segment after each of them.

    Args:
        u: input, shape (N,), NaN where nothing was received.
        y: output, shape (N,), NaN where nothing was received.
        sample_time_s: time between samples.
        starts: segment starts that are known already, as indices into u and y.
    """
    u_array, y_array = np.asarray(u, dtype=np.float64), np.asarray(y, dtype=np.float64)
    good = np.isfinite(u_array) & np.isfinite(y_array)
    begins = good & ~np.concatenate([[False], good[:-1]])
    known = np.zeros_like(good)
    known[list(starts)] = True
    # A known start that lies in a hole is covered by the first good sample after the hole.
    begins |= good & known
    kept_starts = tuple(int(start) for start in np.flatnonzero(begins[good]))
    return Dataset(u=u_array[good], y=y_array[good], sample_time_s=sample_time_s, starts=kept_starts or (0,))
