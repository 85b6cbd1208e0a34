"""How large a hidden effect is in what can be measured: its gap, in units of the noise rms, without noise.

The gap of an effect is what it changes in the disagreement between the sensor and the nameplate's linear joint that is
driven by the recorded input: noise-free sensor minus joint, with the effect, less the same without it. For an effect
that the input does not see this is the difference of the two motions; for an error of the current sensor, which
changes no motion, it is what the joint makes of the wrong current. `recalibrated` is what is left of it after the best
change of viscous friction and torque constant, to first order.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Linear:
    """J dw/dt = Kt i - B w: kg m^2, N m s/rad, N m/A; samples every `step_s`."""

    inertia: float
    viscous: float
    constant: float
    step_s: float

    def respond(self, current: FloatArray) -> FloatArray:
        """Return the speed from rest under a current that is linear between samples, shape (n,)."""
        a = 0.5 * self.step_s * self.viscous / self.inertia
        b = 0.5 * self.step_s * self.constant / self.inertia
        return np.asarray(lfilter([b, b], [1.0 + a, a - 1.0], current))

    def sensitivities(self, current: FloatArray) -> FloatArray:
        """Return d(speed) by d(log Kt), d(log B), a change of the starting speed, shape (n, 3)."""
        speed = self.respond(current)
        less = -self.viscous / self.constant * self.respond(speed)
        start = np.exp(-np.arange(current.size) * self.step_s * self.viscous / self.inertia)
        return np.stack([speed, less, start], axis=1)


def rms(values: FloatArray) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def gap_of(
    joint: Linear, shown: tuple[FloatArray, FloatArray], driven: tuple[FloatArray, FloatArray]
) -> tuple[float, float]:
    """Return the gap and what recalibration leaves of it, rad/s rms.

    Args:
        joint: the nameplate's.
        shown: noise-free sensor with and without the effect, shape (n,) each.
        driven: recorded input with and without it, shape (n,) each.
    """
    difference = shown[0] - shown[1] - joint.respond(driven[0] - driven[1])
    columns = joint.sensitivities(driven[0])
    best, *_ = np.linalg.lstsq(columns, difference, rcond=None)
    return rms(difference), rms(difference - columns @ best)
