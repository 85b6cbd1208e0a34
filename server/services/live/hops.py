"""Work on an endless signal in windows that lie on a fixed grid, so that the numbers do not depend on how it came.

Theory of operation. A filter that looks `margin` rows ahead and back is given windows of `margin + hop + margin` rows;
of each result only the middle is kept. Windows begin at whole multiples of `hop` (less the margin) from the signal's
first row, never at the rows that happened to be there: live blocks, a replayed journal and a recording read at once
give the same windows, and so the same numbers to the last digit.
"""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]
Work = Callable[[Matrix, int, int], Matrix]


class HopWindow:
    """One signal of several columns, window by window; a copy (`copy.copy`) goes on by itself.

    Args:
        width: number of columns.
        hop: rows whose results are kept of each window.
        margin: rows that the work looks ahead and back.
        work: takes a window of shape (rows, width) and the first and the last but one row to be kept; returns their
            results.
    """

    def __init__(self, *, width: int, hop: int, margin: int, work: Work) -> None:
        self._hop = hop
        self._margin = margin
        self._work = work
        self._kept: Matrix = np.empty((0, width))
        self._first = 0  # row of the signal that `_kept` begins with
        self._done = 0  # rows whose results were given

    @property
    def begun(self) -> bool:
        """Whether any row has come."""
        return self._first + len(self._kept) > 0

    def push(self, rows: Matrix) -> Iterator[Matrix]:
        """Append rows, shape (n, width), and give what can be worked out now."""
        self._kept = np.concatenate([self._kept, rows])
        while self._first + len(self._kept) >= self._done + self._hop + self._margin:
            yield self._next(self._done + self._hop, self._done + self._hop + self._margin)

    def flush(self) -> Iterator[Matrix]:
        """Give the rest: the signal ends here."""
        end = self._first + len(self._kept)
        if end > self._done:
            yield self._next(end, end)

    def _next(self, keep_until: int, stop: int) -> Matrix:
        start = max(0, self._done - self._margin)
        window = self._kept[start - self._first : stop - self._first]
        result = self._work(window, self._done - start, keep_until - start)
        self._done = keep_until
        first = max(0, self._done - self._margin)
        self._kept, self._first = self._kept[first - self._first :], first
        return result
