"""Speed from position: the zero-phase way for recordings and the causal one for live data.

Both are given by the same options; `describe_zero_phase` and `CausalSpeedFilter.spec` say what the chosen
filter does (bandwidth, delay, noise), computed from its impulse response and not from a formula, so the
figures hold for every method in the table.
"""

import math
from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import Final, Protocol

import numpy as np
import numpy.typing as npt

from daq.speed.kalman import KalmanSpeed
from daq.speed.options import SpeedFilterSpec, SpeedMethod, SpeedOptions
from daq.speed.savitzky_golay import SavitzkyGolaySpeed

FloatArray = npt.NDArray[np.float64]


class SpeedEstimator(Protocol):
    """One method of computing speed, made for one sample time and bandwidth."""

    def zero_phase(self, position: FloatArray) -> FloatArray:
        """Return the speed of a gap-free run of uniform samples, without delay, shape (n,)."""

    def init(self) -> FloatArray:
        """Return the state of a filter that has seen nothing."""

    def step(self, state: FloatArray, position: FloatArray) -> FloatArray:
        """Advance `state` in place over a block of at least one sample; return its speed, shape (n,)."""


class _EstimatorFactory(Protocol):
    def __call__(self, sample_time_s: float, bandwidth_hz: float) -> SpeedEstimator: ...


SPEED_METHODS: Final[Mapping[SpeedMethod, _EstimatorFactory]] = MappingProxyType(
    {SpeedMethod.KALMAN: KalmanSpeed, SpeedMethod.SAVITZKY_GOLAY: SavitzkyGolaySpeed}
)

DEFAULT_OPTIONS: Final = SpeedOptions()


def speed_from_position_zero_phase(
    position_rad: FloatArray, sample_time_s: float, options: SpeedOptions = DEFAULT_OPTIONS
) -> FloatArray:
    """Return the speed of a gap-free run, without delay.

    Args:
        position_rad: uniform samples, shape (n,); any unit of length or angle.
        sample_time_s: time between them.
        options: method and bandwidth.

    Returns:
        Speed in the position's unit per second, shape (n,); zero for a single sample.

    Raises:
        ValueError: the bandwidth is out of range, or a position is not finite.
    """
    position = np.ascontiguousarray(position_rad, dtype=np.float64)
    if not np.isfinite(position).all():
        row = int(np.flatnonzero(~np.isfinite(position))[0])
        raise ValueError(f"position at row {row} is {position[row]}; cut the record into finite runs first")
    options.check(sample_time_s)
    if not position.size:
        return position
    return SPEED_METHODS[options.method](sample_time_s, options.bandwidth_hz).zero_phase(position)


class CausalSpeedFilter:
    """Speed of live data, block by block; the same numbers whatever the size of the blocks.

    After a gap in the data start anew with `init`: a filter carried across would see a jump.

    Args:
        sample_time_s: time between samples.
        options: method and bandwidth (of the zero-phase filter of the same method; `spec` has the causal
            one's).

    Raises:
        ValueError: the bandwidth is out of range.
    """

    def __init__(self, sample_time_s: float, options: SpeedOptions = DEFAULT_OPTIONS) -> None:
        options.check(sample_time_s)
        self._estimator = SPEED_METHODS[options.method](sample_time_s, options.bandwidth_hz)
        self.spec = _describe_causal(sample_time_s, options)

    def init(self) -> FloatArray:
        """Return the state of a filter that has seen nothing; copy it to keep a moment of it."""
        return self._estimator.init()

    def step(self, state: FloatArray, position_rad: FloatArray) -> FloatArray:
        """Advance `state` in place over positions of shape (n,); return their speeds in rad/s, shape (n,)."""
        position = np.ascontiguousarray(position_rad, dtype=np.float64)
        return self._estimator.step(state, position) if position.size else position


@lru_cache(maxsize=16)
def describe_zero_phase(sample_time_s: float, options: SpeedOptions = DEFAULT_OPTIONS) -> SpeedFilterSpec:
    """State what the zero-phase filter does with these options."""
    reach = _settling_samples(sample_time_s, options)
    impulse = np.zeros(2 * reach + 1)
    impulse[reach] = 1.0
    response = speed_from_position_zero_phase(impulse, sample_time_s, options)
    return _describe(response, reach, sample_time_s, options.method)


@lru_cache(maxsize=16)
def _describe_causal(sample_time_s: float, options: SpeedOptions) -> SpeedFilterSpec:
    reach = _settling_samples(sample_time_s, options)
    estimator = SPEED_METHODS[options.method](sample_time_s, options.bandwidth_hz)
    state = estimator.init()
    estimator.step(state, np.zeros(reach))
    impulse = np.zeros(reach)
    impulse[0] = 1.0
    return _describe(estimator.step(state, impulse), 0, sample_time_s, options.method)


def _settling_samples(sample_time_s: float, options: SpeedOptions) -> int:
    return math.ceil(6.0 / (options.bandwidth_hz * sample_time_s))


def _describe(
    impulse_response: FloatArray, origin: int, sample_time_s: float, method: SpeedMethod
) -> SpeedFilterSpec:
    """Compare a response to an impulse at sample `origin` with an ideal differentiator's."""
    time = (np.arange(len(impulse_response)) - origin) * sample_time_s

    def relative(frequency_hz: float) -> complex:
        omega = 2.0 * math.pi * frequency_hz
        return complex(impulse_response @ np.exp(-1j * omega * time)) / (1j * omega)

    def delay_s(frequency_hz: float) -> float:
        return float(-np.angle(relative(frequency_hz))) / (2.0 * math.pi * frequency_hz)

    settled_hz = 1.0 / (len(impulse_response) * sample_time_s)
    bandwidth_hz = _first_crossing(
        lambda frequency_hz: abs(relative(frequency_hz)), math.sqrt(0.5), settled_hz
    )
    return SpeedFilterSpec(
        method=method,
        bandwidth_hz=bandwidth_hz,
        delay_s=abs(round(delay_s(bandwidth_hz / 30.0), 6)),
        delay_half_band_s=abs(round(delay_s(bandwidth_hz / 2.0), 6)),
        noise_gain_per_s=float(np.sqrt(impulse_response @ impulse_response)),
        sample_time_s=sample_time_s,
    )


class _Gain(Protocol):
    def __call__(self, frequency_hz: float, /) -> float: ...


def _first_crossing(gain: _Gain, level: float, start_hz: float) -> float:
    """Return the lowest frequency at which a gain falls through a level: scan upwards, then bisect."""
    high = start_hz
    while gain(high) > level:
        high *= 1.1
    low = high / 1.1
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if gain(middle) > level else (low, middle)
    return 0.5 * (low + high)
