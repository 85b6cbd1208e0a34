"""The table of all messages, and their way into octets and back; docs/protocol.md, "Messages".

The messages themselves are in `commands.py`, `replies.py` and `reports.py`. This file packs and unpacks by
the rules each class states (`TYPE`, `FORMAT`, `TAIL`); it knows nothing of frames, retries or meaning.

Encoding a value that does not fit its field is our fault: ValueError. Decoding octets that are no message
is the other side's: FrameError.
"""

import struct
from dataclasses import fields
from types import MappingProxyType
from typing import Final

from daq.errors import FrameError
from daq.protocol.codes import SUCCESSES
from daq.protocol.commands import (
    Arm,
    CaptureArm,
    CaptureConfig,
    CaptureRead,
    ClearFault,
    DictRead,
    Disarm,
    Estop,
    EventAck,
    Hello,
    KeepAlive,
    LinkStats,
    ParamGet,
    ParamSave,
    ParamSet,
    Ping,
    Run,
    RunAbort,
    SetBaud,
    SetpointBegin,
    SetpointChunk,
    StreamConfig,
    StreamStart,
    StreamStop,
    WaveBegin,
    WaveCommit,
    WaveData,
)
from daq.protocol.message import REPLY_BIT, Command, Message, Reply, Report, Tail
from daq.protocol.replies import (
    ArmReply,
    CaptureArmReply,
    CaptureConfigReply,
    CaptureReadReply,
    ClearFaultReply,
    DictReadReply,
    DisarmReply,
    EstopReply,
    EventAckReply,
    HelloReply,
    KeepAliveReply,
    LinkStatsReply,
    ParamGetReply,
    ParamSaveReply,
    ParamSetReply,
    PingReply,
    Refusal,
    RunAbortReply,
    RunReply,
    SetBaudReply,
    SetpointBeginReply,
    SetpointChunkReply,
    StreamConfigReply,
    StreamStartReply,
    StreamStopReply,
    WaveBeginReply,
    WaveCommitReply,
    WaveDataReply,
)
from daq.protocol.reports import Event, Status, Stream

EXCHANGES: Final[tuple[tuple[type[Command], type[Reply]], ...]] = (
    (Hello, HelloReply),
    (DictRead, DictReadReply),
    (Ping, PingReply),
    (LinkStats, LinkStatsReply),
    (SetBaud, SetBaudReply),
    (EventAck, EventAckReply),
    (ParamGet, ParamGetReply),
    (ParamSet, ParamSetReply),
    (ParamSave, ParamSaveReply),
    (StreamConfig, StreamConfigReply),
    (StreamStart, StreamStartReply),
    (StreamStop, StreamStopReply),
    (Arm, ArmReply),
    (KeepAlive, KeepAliveReply),
    (Disarm, DisarmReply),
    (Estop, EstopReply),
    (ClearFault, ClearFaultReply),
    (Run, RunReply),
    (RunAbort, RunAbortReply),
    (WaveBegin, WaveBeginReply),
    (WaveData, WaveDataReply),
    (WaveCommit, WaveCommitReply),
    (SetpointBegin, SetpointBeginReply),
    (SetpointChunk, SetpointChunkReply),
    (CaptureConfig, CaptureConfigReply),
    (CaptureArm, CaptureArmReply),
    (CaptureRead, CaptureReadReply),
)
"""Each command with its reply."""

REPORTS: Final[tuple[type[Report], ...]] = (Stream, Event, Status)

MESSAGES: Final = MappingProxyType(
    {message.TYPE: message for message in (*[kind for pair in EXCHANGES for kind in pair], *REPORTS)}
)
"""Every message class by its type octet."""


class _Codec:
    """The compiled form of one message class: its struct, its fields' names, its tail."""

    __slots__ = ("head", "kind", "names", "tail", "tail_name")

    def __init__(self, kind: type[Message]) -> None:
        names = [field.name for field in fields(kind)]
        self.kind = kind
        self.head = struct.Struct("<BB" + kind.FORMAT)
        self.tail = kind.TAIL
        self.tail_name = "" if kind.TAIL is Tail.NONE else names.pop()
        self.names = tuple(names)

    def pack(self, seq: int, message: Message) -> bytes:
        values = [getattr(message, name) for name in self.names]
        tail = getattr(message, self.tail_name) if self.tail_name else b""
        try:
            return self.head.pack(self.kind.TYPE, seq, *values) + _pack_tail(self.tail, tail)
        except struct.error as exc:
            shown = ", ".join(f"{name}={value!r}" for name, value in zip(self.names, values, strict=True))
            raise ValueError(
                f"{self.kind.__name__}({shown}) does not fit its fields ({self.kind.FORMAT}): {exc}"
            ) from exc

    def unpack(self, body: bytes) -> Message:
        if len(body) < self.head.size:
            raise FrameError(f"{self.kind.__name__} of {len(body)} octets is shorter than {self.head.size}")
        values = dict(zip(self.names, self.head.unpack_from(body)[2:], strict=True))
        rest = body[self.head.size :]
        if self.tail_name:
            values[self.tail_name] = _unpack_tail(self.tail, rest, self.kind.__name__)
        elif rest:
            raise FrameError(f"{self.kind.__name__} of {len(body)} octets is longer than {self.head.size}")
        return self.kind(**values)


def _pack_tail(tail: Tail, value: bytes | tuple[int, ...]) -> bytes:
    if isinstance(value, tuple):
        return struct.pack(f"<H{len(value)}I", len(value), *value)
    if tail in (Tail.NONE, Tail.REST):
        return value
    if tail is Tail.OCTETS:
        return struct.pack("<H", len(value)) + value + b"\0" * (len(value) % 2)
    if len(value) % 2:
        raise ValueError(f"{len(value)} octets are no whole number of 16-bit words")
    return struct.pack("<H", len(value) // 2) + value


def _unpack_tail(tail: Tail, rest: bytes, name: str) -> bytes | tuple[int, ...]:
    if tail is Tail.REST:
        return rest
    if len(rest) < 2:
        raise FrameError(f"{name} ends before the length of its last field")
    count = int.from_bytes(rest[:2], "little")
    rest = rest[2:]
    size = {Tail.OCTETS: count + count % 2, Tail.WORDS: 2 * count, Tail.RATES: 4 * count}[tail]
    if len(rest) != size:
        raise FrameError(f"{name} announces {size} octets in its last field but carries {len(rest)}")
    if tail is Tail.RATES:
        return struct.unpack(f"<{count}I", rest)
    return rest[:count] if tail is Tail.OCTETS else rest


_CODECS: Final = MappingProxyType({kind.TYPE: _Codec(kind) for kind in MESSAGES.values()})


def encode_message(seq: int, message: Message) -> bytes:
    """Pack a message with its sequence number (0 to 255); the result goes to `encode_frame`.

    Raises:
        ValueError: A value does not fit its field.
    """
    if isinstance(message, Refusal):
        return struct.pack("<BBH", message.command | REPLY_BIT, seq, message.status)
    return _CODECS[message.TYPE].pack(seq, message)


def decode_message(body: bytes) -> tuple[int, Message]:
    """Unpack a message (without CRC) into its sequence number and record.

    Raises:
        FrameError: The octets are no message of this protocol.
    """
    if len(body) < 2:
        raise FrameError(f"message of {len(body)} octets has no header")
    codec = _CODECS.get(body[0])
    if codec is None:
        raise FrameError(f"unknown message type 0x{body[0]:02x}")
    if len(body) == 4 and codec.head.size > 4 and issubclass(codec.kind, Reply):
        status = body[2] | body[3] << 8
        if status not in SUCCESSES:
            return body[1], Refusal(status=status, command=body[0] & ~REPLY_BIT)
    return body[1], codec.unpack(body)
