"""What all messages have in common: the three kinds, and the ways a message may end.

A message on the wire is `type u8, seq u8`, then the fixed fields (struct format `FORMAT`, little endian),
then, for some, a tail of variable length. The sequence number belongs to the link, not to the message. The
kinds themselves are abstract; `commands.py`, `replies.py` and `reports.py` hold the messages, `messages.py`
the table and the codec.
"""

from dataclasses import dataclass
from enum import Enum
from typing import ClassVar, Final

REPLY_BIT: Final = 0x40
MAX_DATA_OCTETS: Final = 192
"""Octets of data that one message carries at most (DICT_READ, CAPTURE_READ, WAVE_DATA, SETPOINT_CHUNK)."""


class Tail(Enum):
    """What follows the fixed fields of a message."""

    NONE = "nothing"
    OCTETS = "u16 number of octets, the octets, one zero octet when the number is odd"
    WORDS = "u16 number of 16-bit words, the words"
    RATES = "u16 number of entries, u32 each"
    REST = "samples up to the end of the message; the header says how many"


@dataclass(frozen=True, slots=True, kw_only=True)
class Message:
    """Abstract: any message. `TYPE` is its first octet, `FORMAT` its fixed fields, `TAIL` how it ends."""

    TYPE: ClassVar[int]
    FORMAT: ClassVar[str] = ""
    TAIL: ClassVar[Tail] = Tail.NONE


class Command(Message):
    """Abstract: host to controller, types 0x01 to 0x3F."""

    __slots__ = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Reply(Message):
    """Abstract: answer of the controller, type of the command + 0x40; `status` is a `StatusCode`."""

    status: int


class Report(Message):
    """Abstract: sent by the controller unasked, types from 0x80."""

    __slots__ = ()
