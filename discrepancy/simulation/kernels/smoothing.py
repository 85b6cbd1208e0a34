"""The zero-phase smoothing that a derived speed column has passed, applied to the simulated speed too.

Speed is seldom measured: it is differentiated from a position and smoothed without delay (a smoother, or a filter run
forwards and backwards). What that takes away from the measurement must be taken from the simulation as well, or it
looks like a missing effect. The filter is a Butterworth filter of order n run both ways, gain 1 / (1 + (f/fc)^(2 n)):
n = 2 is the usual offline filter and the smoother of white acceleration, n = 3 that of white jerk.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_HIGHEST = 0.4
"""A corner beyond this part of the sampling frequency takes nothing away that the samples could show."""
REACH = 6.0
"""The ends are extended by so many time constants."""


def is_invisible(time_constant: float, step: float) -> bool:
    """Return whether samples `step` apart, s, are left as they are by a smoothing with this time constant, s."""
    return step / (2.0 * math.pi * time_constant) > _HIGHEST


@njit(cache=True, error_model="numpy")
def _pass(x: FloatArray, c: float, third: bool) -> None:
    """Run the filter once over `x` in place, beginning at rest at its first value; `c` is tan(pi fc h)."""
    damping = 1.0 if third else math.sqrt(2.0)
    gain = 1.0 / (1.0 + damping * c + c * c)
    b = c * c * gain
    a1, a2 = 2.0 * (c * c - 1.0) * gain, (1.0 - damping * c + c * c) * gain
    pole, lead = (c - 1.0) / (c + 1.0), c / (c + 1.0)
    x1, x2, y1, y2, u1, z1 = x[0], x[0], x[0], x[0], x[0], x[0]
    for k in range(x.size):
        value = b * (x[k] + 2.0 * x1 + x2) - a1 * y1 - a2 * y2
        x2, x1 = x1, x[k]
        y2, y1 = y1, value
        if third:
            z1 = lead * (value + u1) - pole * z1
            u1 = value
            value = z1
        x[k] = value


@njit(cache=True, error_model="numpy")
def smooth_speed(
    speed: FloatArray, windows: NDArray[np.int64], step: float, time_constant: float, order: float
) -> None:
    """Smooth a simulated speed in place, fresh window by fresh window.

    Args:
        speed: shape (n,).
        windows: first sample of each window, `-k - 1` for one that begins afresh.
        step: sample time, s.
        time_constant: 1 / (2 pi fc), s.
        order: 2 or 3.
    """
    ratio = step / (2.0 * math.pi * time_constant)
    if ratio > _HIGHEST:
        return
    c, third = math.tan(math.pi * ratio), order > 2.5
    for m in range(windows.size):
        a = windows[m] if windows[m] >= 0 else -windows[m] - 1
        if windows[m] >= 0 and m > 0:
            continue
        b = speed.size
        for later in range(m + 1, windows.size):
            if windows[later] < 0:
                b = -windows[later] - 1
                break
        size = b - a
        more = min(size - 1, int(REACH * time_constant / step) + 1)
        if size < 3:
            continue
        # Odd reflection about the end points keeps value and slope.
        x = np.empty(size + 2 * more)
        for k in range(more):
            x[k] = 2.0 * speed[a] - speed[a + more - k]
            x[more + size + k] = 2.0 * speed[b - 1] - speed[b - 2 - k]
        x[more : more + size] = speed[a:b]
        _pass(x, c, third)
        backwards = x[::-1].copy()
        _pass(backwards, c, third)
        speed[a:b] = backwards[::-1][more : more + size]
