"""Speed by a Savitzky-Golay differentiator: the slope of a cubic fitted to a window, at the window's centre.

Live, the slope is known half a window late: a pure delay that is the same at all frequencies. For recordings
the same taps are centred. The window is the one whose gain falls to 0.707 of an ideal differentiator's
nearest to the asked bandwidth. Near the ends of a run the cubic of the first and last whole window is used; a
run shorter than the window gets the cubic (or lower, for fewer than four samples) through all of it.

Source: Savitzky and Golay, Analytical Chemistry 36 (1964) 1627. Live cost: one multiplication per tap and
    sample.
"""

from functools import lru_cache
from typing import Final

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

_ORDER: Final = 3
# Bandwidth times window length of a cubic's slope, in the limit of many taps: solves gain = 0.707.
_BANDWIDTH_TIMES_WINDOW: Final = 1.2481


@lru_cache(maxsize=16)
def _design(relative_bandwidth: float) -> FloatArray:
    from scipy.signal import savgol_coeffs  # slow to import, needed only here

    half = max(2, round((_BANDWIDTH_TIMES_WINDOW / relative_bandwidth - 1.0) / 2.0))
    taps: FloatArray = savgol_coeffs(2 * half + 1, _ORDER, deriv=1)
    return taps


class SavitzkyGolaySpeed:
    """The method `SpeedMethod.SAVITZKY_GOLAY` for one sample time and bandwidth."""

    def __init__(self, sample_time_s: float, bandwidth_hz: float) -> None:
        self.sample_time_s = sample_time_s
        self._taps = _design(bandwidth_hz * sample_time_s)

    def zero_phase(self, position: FloatArray) -> FloatArray:
        """Return the speed of a gap-free run, shape (n,)."""
        from scipy.signal import oaconvolve  # slow to import, needed only here

        window, n = len(self._taps), len(position)
        if n <= window:
            return _polynomial_slope(position) / self.sample_time_s
        half = window // 2
        speed = np.empty(n)
        # Convolving differences from the start keeps the FFT's rounding small beside the speed.
        speed[half : n - half] = oaconvolve(position - position[0], self._taps, mode="valid")
        speed[:half] = _polynomial_slope(position[:window])[:half]
        speed[n - half :] = _polynomial_slope(position[-window:])[half + 1 :]
        speed /= self.sample_time_s
        return speed

    def init(self) -> FloatArray:
        """Return a state that waits for its first sample."""
        return np.full(len(self._taps) - 1, np.nan)

    def step(self, state: FloatArray, position: FloatArray) -> FloatArray:
        """Advance `state` over a block and return the slope half a window before each sample, shape (n,)."""
        from scipy.signal import lfilter  # slow to import, needed only here

        if np.isnan(state[0]):
            state[:] = self._at_rest(position[0])
        # With the denominator (1, 0) scipy adds up sample by sample; with (1) it convolves the block as a
        # whole, and the last digits would depend on where the blocks end.
        speed, state[:] = lfilter(self._taps, np.array([1.0, 0.0]), position, zi=state)
        speed /= self.sample_time_s
        return np.asarray(speed)

    def _at_rest(self, position: float) -> FloatArray:
        """Return the filter's memory after a long stay at one position."""
        # Transposed direct form: memory j holds the sum of the taps behind it times the position.
        behind: FloatArray = np.cumsum(self._taps[:0:-1])[::-1]
        return position * behind


def _polynomial_slope(values: FloatArray) -> FloatArray:
    """Return the slope per sample of a least-squares cubic (or lower, for few samples) at each sample."""
    n = len(values)
    if n == 1:
        return np.zeros(1)
    fit = np.polynomial.Polynomial.fit(np.arange(n), values, min(_ORDER, n - 1))
    slope: FloatArray = fit.deriv()(np.arange(n))
    return slope
