"""Compiled loops over the samples of a recording; plain functions on arrays, nothing else."""

import numpy as np
import numpy.typing as npt
from numba import njit

FloatArray = npt.NDArray[np.float64]


@njit(cache=True)
def average_ahead(time_s: FloatArray, values: FloatArray, span_s: float, means: FloatArray) -> None:
    """Fill `means` with the mean of a signal over `span_s` from each sample on; near the end, over what is left.

    The signal is taken as straight lines between its samples, its integral as straight lines between theirs.

    Args:
        time_s: increasing times, shape (n,).
        values: samples, shape (n,).
        span_s: time to average over, > 0.
        means: written, shape (n,).
    """
    last = time_s.shape[0] - 1
    # Integrals from the first sample to sample k and to sample `right`, the last one within the span.
    begin, end, right = 0.0, 0.0, 0
    for k in range(last):
        stop_s = min(time_s[k] + span_s, time_s[last])
        while right < last and time_s[right + 1] <= stop_s:
            end += (time_s[right + 1] - time_s[right]) * (values[right + 1] + values[right]) / 2.0
            right += 1
        rest = 0.0
        if right < last:
            rest = (stop_s - time_s[right]) * (values[right + 1] + values[right]) / 2.0
        means[k] = (end + rest - begin) / (stop_s - time_s[k])
        begin += (time_s[k + 1] - time_s[k]) * (values[k + 1] + values[k]) / 2.0
    means[last] = values[last]
