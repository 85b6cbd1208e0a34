"""Replies, controller to host: type of the command + 0x40, same sequence number, status first."""

from dataclasses import dataclass
from typing import ClassVar

from daq.protocol.message import Reply, Tail


@dataclass(frozen=True, slots=True, kw_only=True)
class Refusal(Reply):
    """A reply that is its status only, the short form of any refusal; its type is `command` + 0x40."""

    command: int


@dataclass(frozen=True, slots=True, kw_only=True)
class HelloReply(Reply):
    """Identity of the controller; `session` changes with every start of it."""

    TYPE: ClassVar[int] = 0x41
    FORMAT: ClassVar[str] = "HHIIIIIIIIHH"
    TAIL: ClassVar[Tail] = Tail.RATES
    version: int
    cookie: int
    dictionary_crc: int
    dictionary_octets: int
    tick_hz: int
    pwm_hz: int
    session: int
    serial_number: int
    firmware: int
    rx_credits: int
    max_frame: int
    bauds: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class DictReadReply(Reply):
    """Part of the dictionary from `offset`; `total` octets in all."""

    TYPE: ClassVar[int] = 0x42
    FORMAT: ClassVar[str] = "HII"
    TAIL: ClassVar[Tail] = Tail.OCTETS
    offset: int
    total: int
    data: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class PingReply(Reply):
    """Controller time when the ping was executed: tick + subtick / 65536."""

    TYPE: ClassVar[int] = 0x43
    FORMAT: ClassVar[str] = "HIIH"
    cookie: int
    tick: int
    subtick: int


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkStatsReply(Reply):
    """Link counters since boot, and the longest control interrupt in us."""

    TYPE: ClassVar[int] = 0x44
    FORMAT: ClassVar[str] = "HIIIIIIIIH"
    rx_frames: int
    rx_crc_errors: int
    rx_malformed: int
    rx_overruns: int
    rx_unknown: int
    tx_frames: int
    tx_octets: int
    tx_drops: int
    isr_max_us: int


@dataclass(frozen=True, slots=True, kw_only=True)
class SetBaudReply(Reply):
    """Rate that follows this reply."""

    TYPE: ClassVar[int] = 0x45
    FORMAT: ClassVar[str] = "HI"
    baud: int


@dataclass(frozen=True, slots=True, kw_only=True)
class EventAckReply(Reply):
    """Event acknowledged (also when it was not known any more)."""

    TYPE: ClassVar[int] = 0x46
    FORMAT: ClassVar[str] = "HH"
    event: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ParamGetReply(Reply):
    """Raw value in force; SI = raw * scale."""

    TYPE: ClassVar[int] = 0x48
    FORMAT: ClassVar[str] = "HHi"
    parameter: int
    raw: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ParamSetReply(Reply):
    """Raw value now in force; status CLAMPED when it is not the one asked for."""

    TYPE: ClassVar[int] = 0x49
    FORMAT: ClassVar[str] = "HHi"
    parameter: int
    raw: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ParamSaveReply(Reply):
    """Parameters saved."""

    TYPE: ClassVar[int] = 0x4A
    FORMAT: ClassVar[str] = "H"


@dataclass(frozen=True, slots=True, kw_only=True)
class StreamConfigReply(Reply):
    """Stream settings in force."""

    TYPE: ClassVar[int] = 0x50
    FORMAT: ClassVar[str] = "HHHH"
    layout: int
    divisor: int
    batch: int


@dataclass(frozen=True, slots=True, kw_only=True)
class StreamStartReply(Reply):
    """Tick of the first sample."""

    TYPE: ClassVar[int] = 0x51
    FORMAT: ClassVar[str] = "HI"
    tick: int


@dataclass(frozen=True, slots=True, kw_only=True)
class StreamStopReply(Reply):
    """Tick that the sample after the last one would have had."""

    TYPE: ClassVar[int] = 0x52
    FORMAT: ClassVar[str] = "HI"
    tick: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmReply(Reply):
    """Lease in force."""

    TYPE: ClassVar[int] = 0x58
    FORMAT: ClassVar[str] = "HH"
    lease_ms: int


@dataclass(frozen=True, slots=True, kw_only=True)
class KeepAliveReply(Reply):
    """What was left of the lease before it was renewed."""

    TYPE: ClassVar[int] = 0x59
    FORMAT: ClassVar[str] = "HH"
    lease_left_ms: int


@dataclass(frozen=True, slots=True, kw_only=True)
class DisarmReply(Reply):
    """Ramp begun, or drive already off."""

    TYPE: ClassVar[int] = 0x5A
    FORMAT: ClassVar[str] = "H"


@dataclass(frozen=True, slots=True, kw_only=True)
class EstopReply(Reply):
    """Drive is off, emergency stop latched."""

    TYPE: ClassVar[int] = 0x5B
    FORMAT: ClassVar[str] = "H"


@dataclass(frozen=True, slots=True, kw_only=True)
class ClearFaultReply(Reply):
    """Faults still present, whose latches stay."""

    TYPE: ClassVar[int] = 0x5C
    FORMAT: ClassVar[str] = "HH"
    faults: int


@dataclass(frozen=True, slots=True, kw_only=True)
class RunReply(Reply):
    """Tick of the generator's first value."""

    TYPE: ClassVar[int] = 0x60
    FORMAT: ClassVar[str] = "HI"
    start_tick: int


@dataclass(frozen=True, slots=True, kw_only=True)
class RunAbortReply(Reply):
    """Tick at which the ramp began."""

    TYPE: ClassVar[int] = 0x61
    FORMAT: ClassVar[str] = "HI"
    tick: int


@dataclass(frozen=True, slots=True, kw_only=True)
class WaveBeginReply(Reply):
    """Slot open."""

    TYPE: ClassVar[int] = 0x62
    FORMAT: ClassVar[str] = "H"


@dataclass(frozen=True, slots=True, kw_only=True)
class WaveDataReply(Reply):
    """Where the words were put."""

    TYPE: ClassVar[int] = 0x63
    FORMAT: ClassVar[str] = "HHH"
    slot: int
    offset: int


@dataclass(frozen=True, slots=True, kw_only=True)
class WaveCommitReply(Reply):
    """Table playable."""

    TYPE: ClassVar[int] = 0x64
    FORMAT: ClassVar[str] = "H"


@dataclass(frozen=True, slots=True, kw_only=True)
class SetpointBeginReply(Reply):
    """Words that may be sent now."""

    TYPE: ClassVar[int] = 0x65
    FORMAT: ClassVar[str] = "HH"
    free: int


@dataclass(frozen=True, slots=True, kw_only=True)
class SetpointChunkReply(Reply):
    """Words that may be sent next, and words played so far."""

    TYPE: ClassVar[int] = 0x66
    FORMAT: ClassVar[str] = "HHI"
    free: int
    played: int


@dataclass(frozen=True, slots=True, kw_only=True)
class CaptureConfigReply(Reply):
    """Samples that the buffer will hold."""

    TYPE: ClassVar[int] = 0x68
    FORMAT: ClassVar[str] = "HH"
    depth: int


@dataclass(frozen=True, slots=True, kw_only=True)
class CaptureArmReply(Reply):
    """Capture armed."""

    TYPE: ClassVar[int] = 0x69
    FORMAT: ClassVar[str] = "H"


@dataclass(frozen=True, slots=True, kw_only=True)
class CaptureReadReply(Reply):
    """Words from `offset` of `total` (0: not ready yet); `words` holds them little endian."""

    TYPE: ClassVar[int] = 0x6A
    FORMAT: ClassVar[str] = "HHHI"
    TAIL: ClassVar[Tail] = Tail.WORDS
    offset: int
    total: int
    trigger_tick: int
    words: bytes
