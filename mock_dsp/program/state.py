"""Everything that the controller's commands act upon, in one record."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from daq.protocol.codes import PROTOCOL_VERSION
from daq.protocol.device_link import DeviceLink
from mock_dsp.program.baud import BaudSwitch
from mock_dsp.program.capture import CaptureRecorder
from mock_dsp.program.drive import Drive
from mock_dsp.program.events import EventBox
from mock_dsp.program.line_counters import LineCounters
from mock_dsp.program.parameters import ParameterStore
from mock_dsp.program.plant import Plant
from mock_dsp.program.stream import StreamEncoder
from mock_dsp.program.waves import WaveTables

TICK_HZ = 2500
TICK_MASK = 0xFFFFFFFF


@dataclass(frozen=True, slots=True, kw_only=True)
class Identity:
    """What HELLO and DICT_READ tell about the controller.

    Attributes:
        session: boot counter.
        dictionary: compressed dictionary as served.
        dictionary_crc: CRC-32 as announced; another one than the dictionary's is a fault.
        version: the only protocol version spoken.
    """

    session: int
    dictionary: bytes
    dictionary_crc: int
    version: int = PROTOCOL_VERSION
    serial_number: int = 20210414
    firmware: int = 0x0001_0000


class OutFrame(NamedTuple):
    """A frame on its way to the transmitter, and whether it is dropped when there is no room."""

    octets: bytes
    droppable: bool


class ControllerState:
    """The controller's memory, from power-on or restart.

    Args:
        identity: what it tells about itself.
        plant: fast loop and machine; outlives a restart.
        flash: raw parameter values kept over a restart.
        line: losses of the serial line; outlives a restart.
    """

    def __init__(self, identity: Identity, plant: Plant, flash: dict[int, int], line: LineCounters) -> None:
        self.identity = identity
        self.plant = plant
        self.flash = flash
        self.line = line
        self.parameters = ParameterStore(flash)
        self.drive = Drive(plant, self.parameters)
        self.link = DeviceLink()
        self.baud = BaudSwitch(TICK_HZ)
        self.events = EventBox(TICK_HZ)
        self.stream = StreamEncoder()
        self.tx_drops_told = 0
        self._outbox: list[OutFrame] = []
        self.capture = CaptureRecorder()
        self.waves = WaveTables()
        self.time = 0
        self.tick_offset = 0

    @property
    def tick(self) -> int:
        """Tick counter as the host sees it."""
        return self.visible_tick(self.time)

    def queue_droppable(self, frames: Sequence[bytes]) -> None:
        """Queue stream frames behind what the link has made so far."""
        self._collect_link_frames()
        self._outbox += [OutFrame(frame, droppable=True) for frame in frames]

    def take_frames(self) -> list[OutFrame]:
        """Return the frames made since the last call, in order."""
        self._collect_link_frames()
        frames, self._outbox = self._outbox, []
        return frames

    def _collect_link_frames(self) -> None:
        self._outbox += [OutFrame(frame, droppable=False) for frame in self.link.take_frames()]

    def visible_tick(self, time: int) -> int:
        """Return the 32-bit tick counter at a time; `time` counts the same ticks and never jumps."""
        return (time + self.tick_offset) & TICK_MASK
