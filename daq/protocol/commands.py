"""Commands, host to controller, types 0x01 to 0x3F; octets and effects: docs/protocol.md, "Messages"."""

from dataclasses import dataclass
from typing import ClassVar

from daq.protocol.message import Command, Tail


@dataclass(frozen=True, slots=True, kw_only=True)
class Hello(Command):
    """Ask who is there; opens a session of commands."""

    TYPE: ClassVar[int] = 0x01
    FORMAT: ClassVar[str] = "HHI"
    proto_min: int
    proto_max: int
    cookie: int


@dataclass(frozen=True, slots=True, kw_only=True)
class DictRead(Command):
    """Read octets of the dictionary."""

    TYPE: ClassVar[int] = 0x02
    FORMAT: ClassVar[str] = "IH"
    offset: int
    count: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Ping(Command):
    """Ask for the controller's time."""

    TYPE: ClassVar[int] = 0x03
    FORMAT: ClassVar[str] = "I"
    cookie: int


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkStats(Command):
    """Ask for the controller's link counters."""

    TYPE: ClassVar[int] = 0x04


@dataclass(frozen=True, slots=True, kw_only=True)
class SetBaud(Command):
    """Change the baud rate after the reply; reverts after 500 ms without a PING at the new one."""

    TYPE: ClassVar[int] = 0x05
    FORMAT: ClassVar[str] = "I"
    baud: int


@dataclass(frozen=True, slots=True, kw_only=True)
class EventAck(Command):
    """Acknowledge an event, which ends its repetition."""

    TYPE: ClassVar[int] = 0x06
    FORMAT: ClassVar[str] = "H"
    event: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ParamGet(Command):
    """Read a parameter."""

    TYPE: ClassVar[int] = 0x08
    FORMAT: ClassVar[str] = "H"
    parameter: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ParamSet(Command):
    """Write a parameter's raw value."""

    TYPE: ClassVar[int] = 0x09
    FORMAT: ClassVar[str] = "Hi"
    parameter: int
    raw: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ParamSave(Command):
    """Keep the parameters over a power cycle."""

    TYPE: ClassVar[int] = 0x0A


@dataclass(frozen=True, slots=True, kw_only=True)
class StreamConfig(Command):
    """Choose layout, divisor (ticks a sample) and batch (samples a frame)."""

    TYPE: ClassVar[int] = 0x10
    FORMAT: ClassVar[str] = "HHH"
    layout: int
    divisor: int
    batch: int


@dataclass(frozen=True, slots=True, kw_only=True)
class StreamStart(Command):
    """Start the stream."""

    TYPE: ClassVar[int] = 0x11


@dataclass(frozen=True, slots=True, kw_only=True)
class StreamStop(Command):
    """Stop the stream."""

    TYPE: ClassVar[int] = 0x12


@dataclass(frozen=True, slots=True, kw_only=True)
class Arm(Command):
    """Switch the drive on under a lease."""

    TYPE: ClassVar[int] = 0x18
    FORMAT: ClassVar[str] = "IHI"
    session: int
    lease_ms: int
    limits_crc: int


@dataclass(frozen=True, slots=True, kw_only=True)
class KeepAlive(Command):
    """Renew the lease."""

    TYPE: ClassVar[int] = 0x19
    FORMAT: ClassVar[str] = "I"
    session: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Disarm(Command):
    """Ramp to zero and switch the drive off."""

    TYPE: ClassVar[int] = 0x1A


@dataclass(frozen=True, slots=True, kw_only=True)
class Estop(Command):
    """Switch the drive off at once and latch; accepted always."""

    TYPE: ClassVar[int] = 0x1B


@dataclass(frozen=True, slots=True, kw_only=True)
class ClearFault(Command):
    """Leave FAULT or SAFE_TIMEOUT once the cause is gone."""

    TYPE: ClassVar[int] = 0x1C


@dataclass(frozen=True, slots=True, kw_only=True)
class Run(Command):
    """Play a generator; docs/protocol.md, "Generators", gives every formula."""

    TYPE: ClassVar[int] = 0x20
    FORMAT: ClassVar[str] = "HHiiIIHHIIIII"
    generator: int
    flags: int
    amplitude_ua: int
    offset_ua: int
    period_ticks: int
    duration_ticks: int
    phase: int
    ramp_ticks: int
    p1: int
    p2: int
    p3: int
    p4: int
    start_tick: int


@dataclass(frozen=True, slots=True, kw_only=True)
class RunAbort(Command):
    """Ramp the running excitation to zero; the drive stays armed."""

    TYPE: ClassVar[int] = 0x21


@dataclass(frozen=True, slots=True, kw_only=True)
class WaveBegin(Command):
    """Open a table slot for upload."""

    TYPE: ClassVar[int] = 0x22
    FORMAT: ClassVar[str] = "HHI"
    slot: int
    length: int
    crc: int


@dataclass(frozen=True, slots=True, kw_only=True)
class WaveData(Command):
    """Words of a table, from word `offset`; `words` holds i16 current counts, little endian."""

    TYPE: ClassVar[int] = 0x23
    FORMAT: ClassVar[str] = "HH"
    TAIL: ClassVar[Tail] = Tail.WORDS
    slot: int
    offset: int
    words: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class WaveCommit(Command):
    """Check the table's CRC and make it playable."""

    TYPE: ClassVar[int] = 0x24
    FORMAT: ClassVar[str] = "H"
    slot: int


@dataclass(frozen=True, slots=True, kw_only=True)
class SetpointBegin(Command):
    """Start set-point streaming; each word is held for `divisor` ticks."""

    TYPE: ClassVar[int] = 0x25
    FORMAT: ClassVar[str] = "HH"
    divisor: int
    flags: int


@dataclass(frozen=True, slots=True, kw_only=True)
class SetpointChunk(Command):
    """Set-points from word number `first`; `words` holds i16 current counts, little endian."""

    TYPE: ClassVar[int] = 0x26
    FORMAT: ClassVar[str] = "I"
    TAIL: ClassVar[Tail] = Tail.WORDS
    first: int
    words: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class CaptureConfig(Command):
    """Set up the capture buffer."""

    TYPE: ClassVar[int] = 0x28
    FORMAT: ClassVar[str] = "HHHHHh"
    layout: int
    decimation: int
    pretrigger_percent: int
    trigger: int
    channel: int
    level: int


@dataclass(frozen=True, slots=True, kw_only=True)
class CaptureArm(Command):
    """Start filling the capture buffer."""

    TYPE: ClassVar[int] = 0x29


@dataclass(frozen=True, slots=True, kw_only=True)
class CaptureRead(Command):
    """Read words of a finished capture."""

    TYPE: ClassVar[int] = 0x2A
    FORMAT: ClassVar[str] = "HH"
    offset: int
    count: int
