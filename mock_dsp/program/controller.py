"""The controller's program: octets in, frames out, and time that passes in blocks of ticks.

One pass of the background task is `receive`, `serve`, `advance`, `take_frames`. The fast loop runs inside
`advance`, which cuts its block wherever the program has something to do: a lease that ends, a ramp that is
done, an event to repeat, a STATUS that is due. No clock and no port is read here.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from daq.protocol.codes import EventCode, FaultBit
from daq.protocol.framing import MAX_WIRE_OCTETS
from daq.protocol.message import Command
from mock_dsp.program.capture import CapturePhase
from mock_dsp.program.commands import execute
from mock_dsp.program.line_counters import LineCounters
from mock_dsp.program.plant import Plant
from mock_dsp.program.reports import build_status, channel_words, flush_stream, stream_block, stream_status
from mock_dsp.program.setpoints import HALF_WORDS
from mock_dsp.program.state import TICK_HZ, ControllerState, Identity, OutFrame

STATUS_TICKS = TICK_HZ // 10
WATCHDOG_TICKS = TICK_HZ // 5
"""The fast loop switches the bridge off when the background task has not run for this long."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HostDuty:
    """Something the host owes: ticks left until it is due, and ticks that it has for it in all."""

    left_ticks: int
    full_ticks: int


class Controller:
    """One boot of the controller.

    Args:
        identity: what it tells about itself; a restart is a new controller with the next session.
        plant: fast loop and machine, which a restart does not touch.
        flash: raw parameter values that survive a restart.
        line: losses of the serial line.
    """

    def __init__(self, identity: Identity, plant: Plant, flash: dict[int, int], line: LineCounters) -> None:
        self._state = ControllerState(identity, plant, flash, line)
        self._commands: deque[tuple[int, Command]] = deque()
        self._next_status = STATUS_TICKS
        self._watchdog_left = WATCHDOG_TICKS
        self._capture_told = False
        self._post(EventCode.BOOT, identity.session)

    @property
    def time(self) -> int:
        """Ticks since boot."""
        return self._state.time

    @property
    def baud(self) -> int:
        """Rate of the line."""
        return self._state.baud.baud

    @property
    def busy(self) -> bool:
        """Whether something runs that a host waits for: a stream, an excitation, a ramp."""
        drive = self._state.drive
        return self._state.stream.running or drive.moving

    @property
    def powered(self) -> bool:
        """Whether the bridge is switching."""
        return self._state.drive.powered

    def duties(self) -> list[HostDuty]:
        """Return what the host owes now."""
        state = self._state
        duties = []
        if state.drive.lease_runs:
            left = state.drive.lease_left(state.time)
            duties.append(HostDuty(left_ticks=left, full_ticks=state.drive.lease_ticks))
        player = state.drive.setpoints
        if player is not None and player.playing:
            duties.append(HostDuty(left_ticks=player.ticks_left, full_ticks=HALF_WORDS * player.divisor))
        unproven = state.baud.ticks_left(state.time)
        if unproven is not None:
            duties.append(HostDuty(left_ticks=unproven, full_ticks=state.baud.revert_ticks))
        return duties

    def receive(self, octets: bytes) -> None:
        """Take octets from the receive buffer; commands wait until `serve` has room for their replies."""
        self._commands.extend(self._state.link.receive(octets))

    def serve(self, reply_room: int) -> None:
        """Execute waiting commands while the transmitter has room for their replies; kick the watchdog.

        Args:
            reply_room: octets that the transmitter can take.
        """
        self._watchdog_left = WATCHDOG_TICKS
        while self._commands and reply_room >= MAX_WIRE_OCTETS:
            seq, command = self._commands.popleft()
            self._state.link.reply(seq, execute(self._state, command))
            self._post_happenings()
            reply_room -= MAX_WIRE_OCTETS
        self._send_due_reports()

    def advance(self, ticks: int) -> None:
        """Let `ticks` pass."""
        state = self._state
        end = state.time + ticks
        while state.time < end:
            self._run_block(min(end - state.time, self._horizon()))
            self._send_due_reports()

    def jump_ticks(self, ticks: int) -> None:
        """Let the visible tick counter jump; timers and the fast loop do not notice."""
        flush_stream(self._state)
        self._state.tick_offset += ticks
        self._state.stream.tick_offset += ticks

    def take_frames(self) -> Sequence[OutFrame]:
        """Return the frames made since the last call, in the order in which they must go out."""
        return self._state.take_frames()

    def _horizon(self) -> int:
        """Return the ticks until the program has something to do, at least 1."""
        state = self._state
        due = [state.drive.horizon(state.time), self._next_status - state.time]
        event = state.events.next_time()
        if event is not None:
            due.append(event - state.time)
        unproven = state.baud.ticks_left(state.time)
        if unproven is not None:
            due.append(unproven)
        if state.drive.powered:
            due.append(self._watchdog_left)
        return max(1, min(due))

    def _run_block(self, ticks: int) -> None:
        state = self._state
        status = stream_status(state)
        trace = state.drive.advance(state.time, ticks)
        if state.stream.running:
            stream_block(state, trace, status)
        state.capture.feed(state.time, channel_words(trace))
        state.time += trace.ticks_done
        self._watchdog_left -= trace.ticks_done
        if self._watchdog_left <= 0 and state.drive.powered:
            state.drive.trip(FaultBit.WATCHDOG, state.time)
        if state.baud.revert_if_due(state.time):
            self._post(EventCode.BAUD_REVERTED, state.baud.baud)
        self._post_happenings()

    def _send_due_reports(self) -> None:
        state = self._state
        for event in state.events.due(state.time):
            state.link.send(event)
        if state.time >= self._next_status:
            self._next_status = state.time + STATUS_TICKS
            state.link.send(build_status(state))

    def _post_happenings(self) -> None:
        state = self._state
        for happening in state.drive.take_happenings():
            self._post(happening.code, happening.arg)
            if happening.code is EventCode.FAULT:
                state.capture.notice_fault()
        ready = state.capture.phase is CapturePhase.READY
        if ready and not self._capture_told:
            self._post(EventCode.CAPTURE_READY)
        self._capture_told = ready

    def _post(self, code: EventCode, arg: int = 0) -> None:
        self._state.events.post(code, self._state.time, self._state.tick, arg)
