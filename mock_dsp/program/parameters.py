"""The parameter store: raw values in force, clamping, locks, the flash copy and the limits' CRC."""

import struct
import zlib
from collections.abc import Mapping

from daq.protocol.codes import LIMIT_PARAMETERS, ParameterId, StatusCode
from daq.protocol.dictionary_entries import Parameter
from mock_dsp.control.parameters import FastLoopParameters
from mock_dsp.program.parameter_table import PARAMETERS

_TABLE: Mapping[int, Parameter] = {parameter.id: parameter for parameter in PARAMETERS}


class ParameterStore:
    """Raw values by parameter id.

    Args:
        saved: raw values kept over the last restart; what is missing starts at its default.
    """

    def __init__(self, saved: Mapping[int, int]) -> None:
        self._raw = {entry.id: entry.to_raw(entry.default) for entry in PARAMETERS} | dict(saved)

    def si(self, parameter: ParameterId) -> float:
        """Return the value in force in SI units."""
        return _TABLE[parameter].to_si(self._raw[parameter])

    def get(self, parameter: int) -> tuple[StatusCode, int]:
        """Return status and raw value in force (0 for an unknown parameter)."""
        if parameter not in self._raw:
            return StatusCode.UNKNOWN_PARAMETER, 0
        return StatusCode.OK, self._raw[parameter]

    def set(self, parameter: int, raw: int, *, armed: bool) -> tuple[StatusCode, int]:
        """Write a raw value, clamped to its range; return status and raw value in force."""
        entry = _TABLE.get(parameter)
        if entry is None:
            return StatusCode.UNKNOWN_PARAMETER, 0
        if not entry.writable or (armed and not entry.writable_armed):
            return StatusCode.NOT_WRITABLE, self._raw[parameter]
        clamped = min(max(raw, entry.to_raw(entry.minimum)), entry.to_raw(entry.maximum))
        self._raw[parameter] = clamped
        return (StatusCode.OK if clamped == raw else StatusCode.CLAMPED), clamped

    def measure(self, parameter: ParameterId, value_si: float) -> None:
        """Refresh a read-only parameter with a measured value."""
        self._raw[parameter] = _TABLE[parameter].to_raw(value_si)

    def snapshot(self) -> dict[int, int]:
        """Return the raw values of all writable parameters, as PARAM_SAVE keeps them."""
        return {entry.id: self._raw[entry.id] for entry in PARAMETERS if entry.writable}

    def limits_crc(self) -> int:
        """Return the CRC-32 of the limits in force, which ARM must present."""
        values = [self._raw[parameter] for parameter in LIMIT_PARAMETERS]
        return zlib.crc32(struct.pack(f"<{len(values)}i", *values))

    def fast_loop(self, *, pwm_on: bool, centring_on: bool) -> FastLoopParameters:
        """Return the settings for the fast loop."""
        return FastLoopParameters(
            pwm_on=pwm_on,
            centring_on=centring_on,
            centring_gain_a_rad=self.si(ParameterId.CENTRING_GAIN_A_RAD),
            centring_bandwidth_hz=self.si(ParameterId.CENTRING_BANDWIDTH_HZ),
            current_limit_a=self.si(ParameterId.CURRENT_LIMIT_A),
            over_current_a=self.si(ParameterId.OVER_CURRENT_A),
            rated_current_a=self.si(ParameterId.RATED_CURRENT_A),
            i2t_time_s=self.si(ParameterId.I2T_TIME_S),
            speed_limit_rad_s=self.si(ParameterId.SPEED_LIMIT_RAD_S),
            travel_min_rad=self.si(ParameterId.TRAVEL_MIN_RAD),
            travel_max_rad=self.si(ParameterId.TRAVEL_MAX_RAD),
            flux_current_a=self.si(ParameterId.FLUX_CURRENT_A),
            current_loop_bandwidth_hz=self.si(ParameterId.CURRENT_LOOP_BANDWIDTH_HZ),
        )
