"""The table of seeded faults by name: which numbers each one takes, and who injects it.

Wire faults and those of the program are injected by the emulated controller; sensor faults by its fast loop.
"""

from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType


class FaultName(StrEnum):
    """Names of the faults as they stand in a scenario file."""

    BIT_FLIPS = "bit_flips"
    DROPPED_BYTES = "dropped_bytes"
    DUPLICATED_BYTES = "duplicated_bytes"
    BURSTS = "bursts"
    STALL = "stall"
    DISCONNECT = "disconnect"
    REBOOT = "reboot"
    TICK_JUMP = "tick_jump"
    STUCK_SENSOR = "stuck_sensor"
    HALL_OFFSET = "hall_offset"
    OVER_CURRENT = "over_current"
    WRONG_DICTIONARY = "wrong_dictionary"
    NEWER_PROTOCOL = "newer_protocol"


@dataclass(frozen=True, slots=True)
class FaultKind:
    """What one fault takes.

    Attributes:
        text: The fault in words.
        needs: Keys that must be given.
        takes: Keys that may be given besides.
        magnitude: Meaning and unit of `magnitude`; empty when the fault has none.
    """

    text: str
    needs: tuple[str, ...] = ()
    takes: tuple[str, ...] = ()
    magnitude: str = ""


_ON_THE_WIRE = ("at_s", "duration_s")

FAULTS: MappingProxyType[FaultName, FaultKind] = MappingProxyType(
    {
        FaultName.BIT_FLIPS: FaultKind(
            "An octet sent has one bit flipped, each with probability `rate`.", ("rate",), _ON_THE_WIRE
        ),
        FaultName.DROPPED_BYTES: FaultKind(
            "An octet sent is lost, each with probability `rate`.", ("rate",), _ON_THE_WIRE
        ),
        FaultName.DUPLICATED_BYTES: FaultKind(
            "An octet sent arrives twice, each with probability `rate`.", ("rate",), _ON_THE_WIRE
        ),
        FaultName.BURSTS: FaultKind(
            "A run of octets is replaced by noise; `rate` is the probability that one starts at an octet.",
            ("rate", "magnitude"),
            _ON_THE_WIRE,
            "length of a burst in octets",
        ),
        FaultName.STALL: FaultKind(
            "The line is silent, then everything held back arrives.", ("at_s", "duration_s")
        ),
        FaultName.DISCONNECT: FaultKind(
            "The cable is pulled in the middle of a frame and put back.", ("at_s", "duration_s")
        ),
        FaultName.REBOOT: FaultKind("The controller restarts: new session, tick 0, idle.", ("at_s",)),
        FaultName.TICK_JUMP: FaultKind(
            "The tick counter jumps.", ("at_s", "magnitude"), (), "size of the jump in ticks"
        ),
        FaultName.STUCK_SENSOR: FaultKind(
            "The potentiometer repeats its last conversion.", ("at_s",), ("duration_s",)
        ),
        FaultName.HALL_OFFSET: FaultKind(
            "The Hall sensor of phase a shifts.", ("at_s", "magnitude"), ("duration_s",), "shift in A"
        ),
        FaultName.OVER_CURRENT: FaultKind(
            "The Hall sensor of phase a shows a surge, as in a short circuit.",
            ("at_s",),
            ("duration_s", "magnitude"),
            "surge in A, default 3.9",
        ),
        FaultName.WRONG_DICTIONARY: FaultKind(
            "The announced CRC of the dictionary does not match the dictionary."
        ),
        FaultName.NEWER_PROTOCOL: FaultKind(
            "The controller speaks only a later version of the protocol than this one."
        ),
    }
)
