"""The two directions of the serial line between the program and the pseudo-terminal.

Transmit: the program hands over whole frames. They wait in a ring of 512 octets behind the UART's FIFO of
16 and leave it at the modelled baud; a stream frame that does not fit is dropped whole and counted, since
the line has no flow control towards the host. Replies and reports wait in a buffer of their own and go
into the ring before any stream frame; while that buffer is full, commands wait in the receive buffer.

Receive: octets arrive at the modelled baud into the 16-octet FIFO and a buffer of 512; what comes faster
than the program's background task takes it is lost and counted, so a host that ignores its credits sees
the overruns of the real part. Time is counted in controller ticks, never read from a clock.
"""

from collections import deque
from collections.abc import Sequence

from mock_dsp.program.line_counters import LineCounters
from mock_dsp.program.state import OutFrame
from mock_dsp.wire.uart import BITS_PER_OCTET

FIFO_OCTETS = 16
RING_OCTETS = 512
REPLY_OCTETS = 1024
RECEIVE_OCTETS = 512


class OctetClock:
    """Turns ticks into the number of octets that a rate moves in them.

    Args:
        tick_hz: ticks per second.
    """

    def __init__(self, tick_hz: int) -> None:
        self._bits_per_tick_and_octet = tick_hz * BITS_PER_OCTET
        self._remainder = 0

    def elapse(self, ticks: int, baud: int) -> int:
        """Return how many whole octets fit into `ticks`; the rest is kept for the next call."""
        octets, self._remainder = divmod(self._remainder + ticks * baud, self._bits_per_tick_and_octet)
        return octets

    def idle(self) -> None:
        """Forget the part of an octet: an idle line saves up no time."""
        self._remainder = 0


class TransmitLine:
    """Frames in, octets out at the modelled baud, through the ring and the FIFO.

    Args:
        counters: shared with the program, which reports them.
        clock: octets per tick, or None for a line that is as fast as the host reads.
        capacity: octets of ring and FIFO together.
        baud: rate to begin with.

    Attributes:
        baud: rate at which the next octet leaves.
    """

    def __init__(self, counters: LineCounters, clock: OctetClock | None, capacity: int, baud: int) -> None:
        self.baud = baud
        self._counters = counters
        self._clock = clock
        self._capacity = capacity
        self._next_baud = baud
        self._octets_before_switch = 0
        self._ring = bytearray()
        self._waiting: deque[bytes] = deque()

    @property
    def backlog(self) -> int:
        """Octets that have not left yet."""
        return len(self._ring) + self._waiting_octets

    @property
    def reply_room(self) -> int:
        """Octets of replies that may be offered now."""
        return REPLY_OCTETS - self._waiting_octets

    def offer(self, frames: Sequence[OutFrame]) -> None:
        """Take frames over, in order: droppable ones are dropped where the others would wait for room."""
        for frame in frames:
            if not self._waiting and len(self._ring) + len(frame.octets) <= self._capacity:
                self._ring += frame.octets
            elif frame.droppable:
                self._drop(frame.octets)
            else:
                self._waiting.append(frame.octets)
        while self._waiting_octets > REPLY_OCTETS:
            self._drop(self._waiting.popleft())  # nobody takes anything: the oldest news are the least worth

    def follow_baud(self, baud: int) -> None:
        """Change the rate once everything offered so far has left."""
        if baud != self._next_baud:
            self._next_baud = baud
            self._octets_before_switch = self.backlog
            self._switch_if_due()

    def elapse(self, ticks: int) -> bytes:
        """Return the octets that leave the UART during `ticks`, all at the `baud` before the call."""
        octets = self.backlog if self._clock is None else self._clock.elapse(ticks, self.baud)
        if self._clock is not None and octets > self.backlog:
            self._clock.idle()
        if self.baud != self._next_baud:
            octets = min(octets, self._octets_before_switch)
        sent = bytearray()
        while len(sent) < octets and self._ring:
            part = self._ring[: octets - len(sent)]
            del self._ring[: len(part)]
            sent += part
            self._refill()
        self._octets_before_switch -= len(sent)
        self._switch_if_due()
        return bytes(sent)

    def clear(self) -> None:
        """Lose everything that has not left yet, as a reboot does."""
        self._ring.clear()
        self._waiting.clear()
        self._octets_before_switch = 0
        self._switch_if_due()

    @property
    def _waiting_octets(self) -> int:
        return sum(map(len, self._waiting))

    def _drop(self, frame: bytes) -> None:
        self._counters.tx_drops += 1
        self._counters.tx_dropped_octets += len(frame)

    def _switch_if_due(self) -> None:
        if self._octets_before_switch <= 0:
            self.baud = self._next_baud

    def _refill(self) -> None:
        while self._waiting and len(self._ring) + len(self._waiting[0]) <= self._capacity:
            self._ring += self._waiting.popleft()


class ReceiveLine:
    """Octets from the host, arriving at the modelled baud.

    Args:
        counters: shared with the program, which reports them.
        clock: octets per tick, or None for a line without pacing (and without overruns).
    """

    def __init__(self, counters: LineCounters, clock: OctetClock | None) -> None:
        self._counters = counters
        self._clock = clock
        self._on_the_wire = bytearray()

    @property
    def arriving(self) -> bool:
        """Whether octets are still on their way."""
        return bool(self._on_the_wire)

    def send(self, octets: bytes) -> None:
        """Put octets of the host on the wire."""
        self._on_the_wire += octets

    def elapse(self, ticks: int, baud: int) -> bytes:
        """Return what the background task finds in its buffer after `ticks`."""
        if self._clock is None:
            arrived = bytes(self._on_the_wire)
            self._on_the_wire.clear()
            return arrived
        octets = self._clock.elapse(ticks, baud)
        if octets > len(self._on_the_wire):
            self._clock.idle()
        arrived = bytes(self._on_the_wire[:octets])
        del self._on_the_wire[:octets]
        room = RECEIVE_OCTETS + FIFO_OCTETS
        self._counters.rx_overruns += max(0, len(arrived) - room)
        return arrived[:room]

    def clear(self) -> None:
        """Lose what is on the wire, as a pulled cable does."""
        self._on_the_wire.clear()
