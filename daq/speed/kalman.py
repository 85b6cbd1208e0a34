"""Speed by a Kalman filter (live) and its fixed-interval smoother (recordings).

Theory of operation. The position is taken for a triple integral of white jerk of intensity q, seen through
white noise of variance r on each sample. Only q T / r matters, and it is set by the bandwidth: in continuous
time the smoother's gain is 1 / (1 + (w / w0)^6) of an ideal differentiator's, with w0^6 = q / (r T), so that
it falls to 0.707 at 0.863 w0; the filter's is w0^2 (2 s + w0) / (s^3 + 2 w0 s^2 + 2 w0^2 s + w0^3), which has
no delay at low frequencies and pays for it with noise. The gains start wide open (large start variance) and
settle within about 4 / w0, therefore neither the start nor the end of a run needs any padding, and short runs
get the best straight-line estimate there is.

Sources: Rauch, Tung, Striebel, AIAA J. 3 (1965) 1445, in the form of Bierman, Automatica 9 (1973) 503
    (modified Bryson-Frazier: no matrix is inverted). About 5 ns a sample for the filter, 10 ns for the
    smoother.
"""

import math
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from daq.speed.kernels import filter_forward, smooth_backward

FloatArray = npt.NDArray[np.float64]

# (w / w0)^6 = sqrt(2) - 1 at the smoother's -3 dB point.
_CORNER_OVER_W0 = (math.sqrt(2.0) - 1.0) ** (1.0 / 6.0)
# Variance of the position before the first sample, in noise variances; speed and acceleration follow by w0.
_START_VARIANCE = 1e6
# After this many 1/w0 the gains differ from the steady state by less than 1e-9.
_SETTLED = 24.0


@lru_cache(maxsize=16)
def _schedule(relative_w0: float) -> FloatArray:
    start = _START_VARIANCE * np.array([1.0, relative_w0**2, relative_w0**4])
    return _make_schedule(relative_w0**6, start, math.ceil(_SETTLED / relative_w0))


def _make_schedule(process: float, start_variance: FloatArray, length: int) -> FloatArray:
    """Return the gains of the first `length` samples after a start, shape (length, 7).

    Not compiled: it runs once for each filter, about 20 us a row, and matrix products in a kernel would make
    numba compile for seconds.

    Args:
        process: intensity of the white jerk over the variance of the position noise, in sample units.
        start_variance: variances of the state before the first sample, shape (3,), noise variance = 1.
        length: rows to compute.
    """
    transition = np.array([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
    noise = process * np.array([[0.05, 0.125, 1.0 / 6.0], [0.125, 1.0 / 3.0, 0.5], [1.0 / 6.0, 0.5, 1.0]])
    predicted = np.diag(start_variance)
    schedule = np.empty((length, 7))
    for row in schedule:
        innovation_variance = predicted[0, 0] + 1.0
        gain = predicted[:, 0] / innovation_variance
        # Joseph's form: stays positive although the variances span ten orders of magnitude.
        reduction = np.eye(3)
        reduction[:, 0] -= gain
        filtered = reduction @ predicted @ reduction.T + np.outer(gain, gain)
        row[:3] = gain
        row[3] = 1.0 / innovation_variance
        row[4:] = filtered[1]
        predicted = transition @ filtered @ transition.T + noise
    return schedule


class KalmanSpeed:
    """The method `SpeedMethod.KALMAN` for one sample time and bandwidth."""

    def __init__(self, sample_time_s: float, bandwidth_hz: float) -> None:
        self.sample_time_s = sample_time_s
        relative_w0 = 2.0 * math.pi * bandwidth_hz / _CORNER_OVER_W0 * sample_time_s
        self._schedule = _schedule(relative_w0)

    def zero_phase(self, position: FloatArray) -> FloatArray:
        """Return the smoothed speed of a gap-free run, shape (n,)."""
        speed, innovation = np.empty_like(position), np.empty_like(position)
        filter_forward(self._schedule, position, _at_rest(position), speed, innovation)
        smooth_backward(self._schedule, innovation, speed)
        speed /= self.sample_time_s
        return speed

    def init(self) -> FloatArray:
        """Return a state that waits for its first sample."""
        return np.zeros(4)

    def step(self, state: FloatArray, position: FloatArray) -> FloatArray:
        """Advance `state` over a block and return the filtered speed, shape (n,)."""
        if state[3] == 0.0:
            state[:] = _at_rest(position)
        speed, innovation = np.empty_like(position), np.empty_like(position)
        filter_forward(self._schedule, position, state, speed, innovation)
        speed /= self.sample_time_s
        return speed


def _at_rest(position: FloatArray) -> FloatArray:
    return np.array([position[0], 0.0, 0.0, 0.0])
