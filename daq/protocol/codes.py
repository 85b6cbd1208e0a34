"""Every number on the wire that has a name: statuses, states, events, faults, generators, parameters.

The numbers are fixed by docs/protocol.md and never reused. Texts here are what the operator reads; nothing
in this file acts on them.
"""

from enum import IntEnum, IntFlag
from types import MappingProxyType
from typing import Final

PROTOCOL_VERSION: Final = 1
"""The only version so far; HELLO carries the range each side can speak."""

CURRENT_COUNT_A: Final = 2.0**-13
"""One count of a current word, in A: +-4 A in an i16."""


class StatusCode(IntEnum):
    """First word of every reply."""

    OK = 0
    CLAMPED = 1
    UNKNOWN_COMMAND = 2
    MALFORMED = 3
    OUT_OF_RANGE = 4
    WRONG_STATE = 5
    WRONG_SESSION = 6
    NOT_WRITABLE = 7
    WRONG_LIMITS = 8
    FAULT_LATCHED = 9
    BUSY = 10
    NO_DATA = 11
    BAD_CRC = 12
    UNSUPPORTED_VERSION = 13
    NO_CREDIT = 14
    UNDERRUN = 15
    UNKNOWN_PARAMETER = 16
    ESTOP_LATCHED = 17


SUCCESSES: Final = frozenset({StatusCode.OK, StatusCode.CLAMPED})
"""Statuses of commands that were carried out; every other one is a refusal."""

STATUS_REMEDIES: Final = MappingProxyType(
    {
        StatusCode.OK: "done",
        StatusCode.CLAMPED: "done with another value than asked for; the reply holds the value in force",
        StatusCode.UNKNOWN_COMMAND: "this controller does not know the command; update its program",
        StatusCode.MALFORMED: "the command's length or fields are wrong; update the older side",
        StatusCode.OUT_OF_RANGE: "a field lies outside the limits of the dictionary; correct the value",
        StatusCode.WRONG_STATE: "not possible in this drive state; disarm, clear the fault or arm first",
        StatusCode.WRONG_SESSION: "the controller has restarted since HELLO; connect again",
        StatusCode.NOT_WRITABLE: "read-only, or locked while the drive is armed; disarm first",
        StatusCode.WRONG_LIMITS: "other limits are in force than the host knows; read the parameters again",
        StatusCode.FAULT_LATCHED: "a fault is latched; find its cause, then clear the fault",
        StatusCode.BUSY: "the controller is still at the last command of this kind; ask again later",
        StatusCode.NO_DATA: "nothing stored there yet; upload the table or wait for the trigger",
        StatusCode.BAD_CRC: "the uploaded words do not match their CRC; upload them again",
        StatusCode.UNSUPPORTED_VERSION: "no common protocol version; update the older side",
        StatusCode.NO_CREDIT: "the controller's receive buffer is full; wait for replies before sending more",
        StatusCode.UNDERRUN: "set-points came too late and the drive ramped to zero; begin again",
        StatusCode.UNKNOWN_PARAMETER: "no parameter has this id; read the dictionary again",
        StatusCode.ESTOP_LATCHED: "the emergency stop is latched; make the rig safe, then clear the fault",
    }
)


class DriveState(IntEnum):
    """State of the drive; docs/protocol.md draws the transitions."""

    IDLE = 0
    ARMED = 1
    RUNNING = 2
    RAMPING = 3
    SAFE_TIMEOUT = 4
    FAULT = 5


class EventCode(IntEnum):
    """What an EVENT reports."""

    BOOT = 1
    STATE = 2
    FAULT = 3
    LIMIT = 4
    LEASE_LOST = 5
    RUN_STARTED = 6
    RUN_DONE = 7
    UNDERRUN = 8
    CAPTURE_READY = 9
    ESTOP = 10
    BAUD_REVERTED = 11


class FaultBit(IntEnum):
    """Bit numbers of the fault word."""

    OVER_CURRENT = 0
    OVER_SPEED = 1
    TRAVEL = 2
    I2T = 3
    SENSOR = 4
    BUS_VOLTAGE = 5
    ESTOP = 6
    TEMPERATURE = 7
    WATCHDOG = 8


class Generator(IntEnum):
    """Excitations that the controller makes itself."""

    SINE = 1
    TRAPEZOID = 2
    CHIRP = 3
    PRBS = 4
    STAIRCASE = 5
    MULTISINE = 6
    TABLE = 7


class RunFlag(IntFlag):
    """Bits of the RUN command's flags."""

    CENTRING = 1
    REPEAT = 2


class SetpointFlag(IntFlag):
    """Bits of the SETPOINT_BEGIN command's flags."""

    CENTRING = 1


class StaircaseMode(IntEnum):
    """Order of a staircase's levels (p3 of the generator)."""

    UP = 0
    UP_DOWN = 1
    FROM_ZERO = 2


class ChirpMode(IntEnum):
    """Law of a chirp's frequency (p3 of the generator)."""

    LINEAR = 0
    LOGARITHMIC = 1


class Trigger(IntEnum):
    """What starts the capture buffer's second part."""

    NOW = 0
    LEVEL = 1
    FAULT = 2


class StreamStatus(IntFlag):
    """Status word of a stream frame; bits 0 to 3 hold the `DriveState` (mask `STATE_MASK`)."""

    FAULT_LATCHED = 1 << 4
    LIMIT_ACTIVE = 1 << 5
    EXCITATION_ACTIVE = 1 << 6
    CAPTURE_READY = 1 << 7
    TX_OVERRUN = 1 << 8
    TRIP_PENDING = 1 << 9
    LEASE_OK = 1 << 10


STATE_MASK: Final = 0x000F
"""The bits of a stream frame's status word that hold the drive state."""


class ParameterId(IntEnum):
    """Numbers of the parameters that every controller has; the dictionary gives units, limits and texts."""

    CURRENT_LIMIT_A = 1
    SPEED_LIMIT_RAD_S = 2
    TRAVEL_MIN_RAD = 3
    TRAVEL_MAX_RAD = 4
    RATED_CURRENT_A = 5
    I2T_TIME_S = 6
    RAMP_TIME_S = 7
    LEASE_DEFAULT_S = 8
    CENTRING_GAIN_A_RAD = 9
    CENTRING_BANDWIDTH_HZ = 10
    FLUX_CURRENT_A = 11
    CURRENT_LOOP_BANDWIDTH_HZ = 12
    BUS_VOLTAGE_V = 13
    TEMPERATURE_DEGC = 14
    OVER_CURRENT_A = 15


LIMIT_PARAMETERS: Final = (
    ParameterId.CURRENT_LIMIT_A,
    ParameterId.SPEED_LIMIT_RAD_S,
    ParameterId.TRAVEL_MIN_RAD,
    ParameterId.TRAVEL_MAX_RAD,
    ParameterId.RATED_CURRENT_A,
    ParameterId.OVER_CURRENT_A,
)
"""The parameters whose raw values ARM's `limits_crc` covers, in this order."""


class LayoutId(IntEnum):
    """Stream layouts that every controller has."""

    CONTROL = 1
    PHASES = 2
    SPEED = 3
