"""Is a test record made of samples that were used for training? Copies, cut pieces and rounded copies count."""

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.series import Series
from discrepancy.errors import GapInputError

FloatArray = NDArray[np.float64]
_PROBE = 200
_SAME = 1e-5
"""Part of the standard deviation within which two samples are the same: what a table with six digits rounds away."""
SHARED = 0.5


def check_independence(train: Series, test: Series) -> None:
    """Refuse a test record that shares its samples with a training record.

    Raises:
        GapInputError: at least half of the test record stands in the training record.
    """
    mine, theirs = _rows(test), _rows(train)
    if mine.shape[0] != theirs.shape[0]:
        return
    scale = np.maximum(mine.std(axis=1, keepdims=True), 1e-300)
    mine, theirs = mine / scale, theirs / scale
    n = test.n
    length = min(_PROBE, n)
    for first in dict.fromkeys((0, (n - length) // 2, n - length)):
        for at in _find(mine[:, first : first + length], theirs):
            if _shared(mine, theirs, at - first) >= SHARED * n:
                raise GapInputError(
                    f"{test.label} is the same recording as {train.label}, or a part of it: a test must not have been "
                    "used for training; record another"
                )


def _rows(series: Series) -> FloatArray:
    return np.stack([series.input, *(channel.values for channel in series.channels)])


def _find(piece: FloatArray, whole: FloatArray) -> list[int]:
    """Return where a piece stands in the whole; nothing for a piece in which nothing changes."""
    length = piece.shape[1]
    if whole.shape[1] < length or float(piece.std(axis=1).min()) < 1e-3:
        return []
    places = np.arange(whole.shape[1] - length + 1)
    for k in range(length):
        places = places[np.all(np.abs(whole[:, places + k] - piece[:, k : k + 1]) < _SAME, axis=0)]
        if not places.size:
            return []
    return [int(at) for at in places[:10]]


def _shared(mine: FloatArray, theirs: FloatArray, shift: int) -> int:
    """Return how many samples are the same when the test's row 0 is the training record's row `shift`."""
    first, last = max(0, -shift), min(mine.shape[1], theirs.shape[1] - shift)
    near = np.abs(mine[:, first:last] - theirs[:, first + shift : last + shift]) < _SAME
    return int(np.all(near, axis=0).sum())
