"""What can be chosen about the speed filter, and what a chosen filter then does, in numbers."""

from dataclasses import dataclass
from enum import Enum
from typing import Final

# Below, variances in the Kalman filter span more than doubles can hold; above, there is nothing left to
# filter.
MIN_RELATIVE_BANDWIDTH: Final = 2e-4
MAX_RELATIVE_BANDWIDTH: Final = 0.1


class SpeedMethod(Enum):
    """How speed is computed from position; the value is the name used in configuration and metadata."""

    KALMAN = "kalman"
    SAVITZKY_GOLAY = "savitzky_golay"


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedOptions:
    """Choice of a speed filter.

    Attributes:
        method: see docs/speed.md for the comparison.
        bandwidth_hz: frequency at which the zero-phase filter's gain has fallen to 0.707 of an ideal
            differentiator's.
    """

    method: SpeedMethod = SpeedMethod.KALMAN
    bandwidth_hz: float = 10.0

    def check(self, sample_time_s: float) -> None:
        """Refuse a bandwidth that this sample time cannot give.

        Raises:
            ValueError: with the range that is possible.
        """
        low, high = MIN_RELATIVE_BANDWIDTH / sample_time_s, MAX_RELATIVE_BANDWIDTH / sample_time_s
        if not low <= self.bandwidth_hz <= high:
            raise ValueError(
                f"speed bandwidth {self.bandwidth_hz:g} Hz must lie between {low:.3g} and {high:.3g} Hz "
                f"at a sample time of {sample_time_s:g} s"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedFilterSpec:
    """What a speed filter does, computed from its impulse response.

    Attributes:
        method: name of the method.
        bandwidth_hz: frequency at which its gain has fallen to 0.707 of an ideal differentiator's.
        delay_s: delay of motions much slower than the bandwidth; 0 for the zero-phase filters.
        delay_half_band_s: delay of motions at half the bandwidth.
        noise_gain_per_s: rms of the speed over rms of white noise on the position, (rad/s)/rad.
        sample_time_s: time between samples it was made for.
    """

    method: SpeedMethod
    bandwidth_hz: float
    delay_s: float
    delay_half_band_s: float
    noise_gain_per_s: float
    sample_time_s: float

    def to_dict(self) -> dict[str, float | str]:
        """Return the figures as JSON values, for a recording's metadata."""
        return {
            "method": self.method.value,
            "bandwidth_hz": self.bandwidth_hz,
            "delay_s": self.delay_s,
            "delay_half_band_s": self.delay_half_band_s,
            "noise_gain_per_s": self.noise_gain_per_s,
            "sample_time_s": self.sample_time_s,
        }
