"""The loop that joins program, line, faults and pseudo-terminal, and decides how fast time passes.

One pass: read what the host sent, let the program answer, let some ticks pass, write what left the line. At
1x and N x the ticks come from the wall clock and the octets at the modelled baud. At speed `max` time runs
freely while something runs (a stream, an excitation); while nothing runs it keeps to the wall clock, so that an
idle controller costs next to nothing. At every speed beyond 1x the host's duties and a port that is full hold time
back: no host promises to be faster than real time.
"""

import math
import select
from collections.abc import Callable
from typing import Protocol

from mock_dsp.program.baud import START_BAUD
from mock_dsp.program.controller import Controller, HostDuty
from mock_dsp.program.line_counters import LineCounters
from mock_dsp.program.state import TICK_HZ
from mock_dsp.scenario.faults import FaultName
from mock_dsp.wire.faults import FaultPlan, TimedFault
from mock_dsp.wire.lines import FIFO_OCTETS, RING_OCTETS, OctetClock, ReceiveLine, TransmitLine
from mock_dsp.wire.pacing import DutyGate, WallPace
from mock_dsp.wire.uart import resample_octets

BLOCK_TICKS = 250
"""Ticks between two looks at the port at speed `max`: 100 ms of emulated time, under 1 ms on the wall."""
PACED_BLOCK_TICKS = 25
"""The same on a paced line: after a late wake-up the octets must leave the ring between the frames that fill it."""
READ_OCTETS = 4096
FREE_RING_OCTETS = 65536
FULL_OCTETS = 4096
"""Octets waiting for a host that does not read, beyond which time is held at speeds beyond 1x."""
PATIENCE_TICKS = TICK_HZ
"""How long, on the wall clock, a driven rig waits for a host that does not read."""
BUSY_WAIT_S = 0.004
IDLE_WAIT_S = 0.05
_BAUD_TOLERANCE = 0.02


class Port(Protocol):
    """Where the host is; `mock_dsp.wire.pty.PtyPort` is the real one."""

    @property
    def is_open(self) -> bool:
        """Whether a host can find the port."""

    def open(self) -> None:
        """Let hosts find the port."""

    def close_when_read(self) -> None:
        """Drop the line once the host has read what was written."""

    def fileno(self) -> int:
        """Return a descriptor for `select`."""

    def host_baud(self) -> int:
        """Return the rate that the host has set."""

    def read(self, limit: int) -> bytes:
        """Return what the host has sent, without waiting."""

    def write(self, octets: bytes) -> int:
        """Pass octets to the host, without waiting; return how many there was room for."""


class Emulation:
    """An emulated controller on a pseudo-terminal.

    Args:
        boot: makes the controller after so many restarts.
        port: where the host is.
        line: losses of the serial line, shared with the program.
        faults: what is to go wrong.
        speed: emulated seconds per second; infinity for as fast as the host takes part.
        clock_ns: monotonic clock.
    """

    def __init__(
        self,
        boot: Callable[[int], Controller],
        port: Port,
        line: LineCounters,
        faults: FaultPlan,
        *,
        speed: float,
        clock_ns: Callable[[], int],
    ) -> None:
        self._boot = boot
        self._port = port
        self._faults = faults
        self._clock_ns = clock_ns
        self._unpaced = math.isinf(speed)
        self._waits = speed > 1.0
        paced = not self._unpaced
        self._transmit = TransmitLine(
            line,
            OctetClock(TICK_HZ) if paced else None,
            RING_OCTETS + FIFO_OCTETS if paced else FREE_RING_OCTETS,
            START_BAUD,
        )
        self._receive = ReceiveLine(line, OctetClock(TICK_HZ) if paced else None)
        self._restarts = 0
        self._controller = boot(self._restarts)
        self._pace = WallPace(TICK_HZ * speed if paced else TICK_HZ, clock_ns())
        self._gate = DutyGate(TICK_HZ)
        self._free = False
        self._elapsed = 0
        self._unsent = b""
        self._stalled_until = 0
        self._unplugged_until = 0
        self._pull_cable = 0

    def run(self, stopping: Callable[[], bool], announce: Callable[[], None]) -> None:
        """Emulate until `stopping` says so; `announce` is called whenever the port is there (again)."""
        announce()
        while not stopping():
            if self.begin_due_faults():
                announce()
            if not self.step():
                self._wait()

    def begin_due_faults(self) -> bool:
        """Begin the faults whose time has come, and end a pulled cable; return whether the port is back."""
        for fault in self._faults.take_due(self._elapsed):
            self._begin_fault(fault)
        if self._port.is_open or self._elapsed < self._unplugged_until:
            return False
        self._port.open()
        return True

    def step(self) -> bool:
        """Do one pass; return whether the next one may follow at once."""
        baud = self._transmit.baud
        self._read_port(baud)
        if self._unpaced:
            self._serve_host(0, baud)  # before time is granted: it may wait for just what has come in
        ticks = self._allowed_ticks()
        if not self._unpaced:
            self._serve_host(ticks, baud)
            ticks = min(ticks, self._block_ticks)  # a stream that has just been started fills the ring
        if not self._free:
            self._pace.grant(ticks)
        if ticks:
            self._controller.advance(ticks)
        self._elapsed += ticks
        self._transmit.offer(self._controller.take_frames())
        self._transmit.follow_baud(self._controller.baud)
        self._write_port(self._transmit.elapse(ticks), baud)
        return ticks == self._block_ticks or (self._free and ticks > 0)

    def _serve_host(self, ticks: int, baud: int) -> None:
        self._controller.receive(self._receive.elapse(ticks, baud))
        self._controller.serve(self._transmit.reply_room)

    @property
    def _block_ticks(self) -> int:
        return BLOCK_TICKS if self._unpaced or not self._controller.busy else PACED_BLOCK_TICKS

    @property
    def _line_down(self) -> bool:
        return not self._port.is_open or self._elapsed < self._stalled_until

    def _allowed_ticks(self) -> int:
        """Return how many ticks may pass in this pass."""
        t_ns = self._clock_ns()
        free = self._unpaced and self._controller.busy and not self._line_down
        if self._free and not free:
            self._pace.restart(t_ns)
        self._free = free
        allowed = min(self._held_ticks(t_ns), self._faults.ticks_to_next(self._elapsed))
        if free:
            return int(min(allowed, self._block_ticks))
        return int(min(allowed, self._pace.due_ticks(t_ns), self._block_ticks))

    def _held_ticks(self, t_ns: int) -> float:
        """Return how many ticks the host's duties allow; a line in real time waits for nobody."""
        if not self._waits or self._line_down:
            return math.inf
        duties = self._controller.duties()
        if self._controller.busy and len(self._unsent) + self._transmit.backlog > FULL_OCTETS:
            if not self._controller.powered:
                return 0
            duties.append(HostDuty(left_ticks=0, full_ticks=PATIENCE_TICKS))
        return self._gate.allow(duties, t_ns)

    def _read_port(self, baud: int) -> None:
        if self._elapsed < self._stalled_until:
            return
        octets = self._port.read(READ_OCTETS)
        if octets:
            self._receive.send(self._through_uart(octets, self._port.host_baud(), baud))

    def _write_port(self, octets: bytes, baud: int) -> None:
        if octets and self._port.is_open:
            octets = self._through_uart(octets, baud, self._port.host_baud())
        self._unsent += self._faults.damage(octets, self._elapsed)
        if self._elapsed < self._stalled_until or not self._unsent:
            return
        if self._pull_cable:
            self._unplug()
            return
        accepted = self._port.write(self._unsent)
        # A real line does not wait: what the host has no room for is lost on it.
        self._unsent = self._unsent[accepted:] if self._waits else b""

    def _through_uart(self, octets: bytes, sent_baud: int, sampled_baud: int) -> bytes:
        if abs(sent_baud - sampled_baud) <= _BAUD_TOLERANCE * sent_baud:
            return octets
        return resample_octets(octets, sent_baud, sampled_baud)

    def _begin_fault(self, fault: TimedFault) -> None:
        if fault.name is FaultName.STALL:
            self._stalled_until = self._elapsed + fault.ticks
        elif fault.name is FaultName.DISCONNECT:
            self._pull_cable = fault.ticks
        elif fault.name is FaultName.TICK_JUMP:
            self._controller.jump_ticks(fault.size)
        elif fault.name is FaultName.REBOOT:
            self._reboot()

    def _reboot(self) -> None:
        """Restart the program; what it had queued is lost, and the line is back at its first rate."""
        self._transmit.clear()
        self._receive.clear()
        self._restarts += 1
        self._controller = self._boot(self._restarts)
        self._transmit.follow_baud(self._controller.baud)

    def _unplug(self) -> None:
        """Let half of the next frame out, then drop the line."""
        self._port.write(half_frame(self._unsent))
        self._port.close_when_read()
        self._unplugged_until = self._elapsed + self._pull_cable
        self._pull_cable = 0
        self._unsent = b""
        self._receive.clear()

    def _wait(self) -> None:
        """Sleep until the host sends, the port has room again, or the next pass is due."""
        active = self._controller.busy or self._receive.arriving or self._transmit.backlog > 0
        timeout_s = BUSY_WAIT_S if active or self._unsent else IDLE_WAIT_S
        if self._line_down:
            select.select([], [], [], timeout_s)
            return
        select.select([self._port], [self._port] if self._unsent else [], [], timeout_s)


def half_frame(octets: bytes) -> bytes:
    """Return the octets up to the middle of a frame, or of the last one that they begin."""
    start = octets.rfind(b"\0", 0, len(octets) // 2) + 1
    end = octets.find(b"\0", start)
    return octets[: (start + (end if end > 0 else len(octets)) + 1) // 2]
