"""Reports, which the controller sends unasked: types from 0x80."""

from dataclasses import dataclass
from typing import ClassVar

from daq.protocol.message import Report, Tail


@dataclass(frozen=True, slots=True, kw_only=True)
class Stream(Report):
    """A batch of samples; sample k was taken at `tick0` + k * divisor. `samples`: `batch` rows of words."""

    TYPE: ClassVar[int] = 0x80
    FORMAT: ClassVar[str] = "BBIH"
    TAIL: ClassVar[Tail] = Tail.REST
    layout: int
    batch: int
    tick0: int
    status: int
    samples: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class Event(Report):
    """Something happened at `tick`; repeated until EVENT_ACK."""

    TYPE: ClassVar[int] = 0x81
    FORMAT: ClassVar[str] = "HHIi"
    event: int
    code: int
    tick: int
    arg: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Status(Report):
    """State of controller and drive, ten times a second."""

    TYPE: ClassVar[int] = 0x82
    FORMAT: ClassVar[str] = "HHHHIIIHHhH"
    state: int
    faults: int
    lease_left_ms: int
    credits: int
    tick: int
    rx_errors: int
    tx_drops: int
    isr_max_us: int
    bus_decivolt: int
    temperature_decicelsius: int
    setpoints_free: int
