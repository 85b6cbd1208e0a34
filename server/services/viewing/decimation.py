"""Columns of samples to fewer rows: the least and the greatest value of each bucket, so that no peak goes unseen."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def min_max_rows(samples: Floats, per_row: int) -> NDArray[np.float32]:
    """Return least and greatest values by bucket, shape (2 columns, rows).

    Args:
        samples: shape (columns, n); a last bucket that is not full counts as one.
        per_row: samples in a bucket.
    """
    starts = np.arange(0, samples.shape[1], per_row)
    rows = np.empty((2 * samples.shape[0], len(starts)), np.float32)
    if len(starts):
        rows[0::2] = np.minimum.reduceat(samples, starts, axis=1)
        rows[1::2] = np.maximum.reduceat(samples, starts, axis=1)
    return rows
