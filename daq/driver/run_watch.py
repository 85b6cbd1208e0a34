"""Watches one run by its samples and events: how far it is, what was lost, and whether the drive still runs."""

import time
from collections.abc import Sequence

from daq.driver.outcome import RecordEnd, RecordOutcome, RecordProgress
from daq.driver.refusals import fault_error
from daq.driver.rig import Rig
from daq.errors import DaqError, DeviceFaultError, LinkTimeoutError
from daq.excitation.check import ExcitationReport
from daq.protocol.codes import STATE_MASK, DriveState, EventCode
from daq.protocol.reports import Event
from daq.protocol.stream import SampleBlock

_FAULT_TEXT_S = 0.5
_SILENCE_S = 5.0
_MAX_START_AHEAD_S = 60
_WRAP = 1 << 32


class RunWatch:
    """State of one recording, from its first sample on.

    Args:
        rig: Where the samples come from.
        duration_s: Length of the recording from the excitation's first tick, s.
    """

    def __init__(self, rig: Rig, duration_s: float) -> None:
        self._rig = rig
        self._duration_s = duration_s
        self._reboots = rig.reboots
        self._samples = self._lost = self._gaps = 0
        self._state = DriveState.IDLE
        self._faults = 0
        self._fault_tick: int | None = None
        self._tripped_s: float | None = None
        self._heard_s = time.monotonic()
        self._link_lost = False
        self.newest_tick = 0
        self.start_tick: int | None = None
        self.underruns = 0

    @property
    def state(self) -> DriveState:
        """The drive's state at the newest sample."""
        return self._state

    def begin(self, start_tick: int) -> None:
        """Take note of the excitation's first tick, as 32 bits of the wire."""
        newest = self.newest_tick
        ahead = (start_tick - newest + _WRAP // 2) % _WRAP - _WRAP // 2
        # A counter that was set back leaves the axis apart from the wire; then the newest sample is as good a start.
        believable = abs(ahead) <= _MAX_START_AHEAD_S * self._rig.hello.tick_hz or newest == 0
        self.start_tick = newest + ahead if believable else newest

    def heed(self, blocks: Sequence[SampleBlock], events: Sequence[Event]) -> None:
        """Take note of samples and events."""
        self._link_lost |= not self._rig.link_up
        if blocks or not self._rig.link_up:
            self._heard_s = time.monotonic()
        for block in blocks:
            self._gaps += len(block.gaps)
            self._lost += sum(gap.missing_samples for gap in block.gaps)
            self._samples += block.ticks.size
            if block.ticks.size:
                self.newest_tick = int(block.ticks[-1])
                state = int(block.status[-1]) & STATE_MASK
                self._state = DriveState(state) if state in tuple(DriveState) else self._state
        for event in events:
            if event.code == EventCode.FAULT and 0 <= event.arg < 16:
                self._faults |= 1 << event.arg
                self._fault_tick = event.tick
            self.underruns += event.code == EventCode.UNDERRUN

    def is_over(self) -> bool:
        """Tell whether the recording is as long as it should be, and no trip is waiting for its text."""
        return self._state is not DriveState.FAULT and self._elapsed_s() >= self._duration_s

    def raise_trouble(self) -> None:
        """Raise what has ended the run before its time, if anything has.

        Raises:
            DeviceFaultError: The drive tripped, lost its lease, or the controller restarted.
            LinkTimeoutError: No samples come although the link is up.
        """
        if self._rig.reboots != self._reboots:
            raise DeviceFaultError(
                "the controller restarted in mid-run, the drive is off; check its supply, then record again",
                faults=0,
            )
        if self._state is DriveState.SAFE_TIMEOUT:
            raise DeviceFaultError(
                "the drive's lease ran out and it ramped down: no keep-alive reached the controller in time, because "
                f"{self._explain_lost_lease()}, then record again",
                faults=self._faults,
            )
        if self._state is DriveState.FAULT:
            self._raise_fault()
        if time.monotonic() - self._heard_s > _SILENCE_S:
            raise LinkTimeoutError(
                f"no sample came for {_SILENCE_S:g} s although the link is up; restart the controller"
            )

    def progress(self) -> RecordProgress:
        """Return where the recording is."""
        return RecordProgress(
            elapsed_s=self._elapsed_s(),
            duration_s=self._duration_s,
            samples=self._samples,
            samples_lost=self._lost,
            link_up=self._rig.link_up,
            trouble=self._rig.link_statistics().cause,
            start_tick=self.start_tick,
        )

    def outcome(self, end: RecordEnd, error: DaqError | None, report: ExcitationReport) -> RecordOutcome:
        """Return how the recording went."""
        return RecordOutcome(
            end=end,
            text=str(error) if error else _TEXTS[end],
            report=report,
            start_tick=self.start_tick or 0,
            samples_expected=self._samples + self._lost,
            samples_received=self._samples,
            samples_lost=self._lost,
            gaps=self._gaps,
            underruns=self.underruns,
            error=error,
        )

    def _elapsed_s(self) -> float:
        if self.start_tick is None:
            return 0.0
        return max(0, self.newest_tick + 1 - self.start_tick) / self._rig.hello.tick_hz

    def _explain_lost_lease(self) -> str:
        if self._link_lost:
            return "the link was lost in between; check the cable and its plugs, clear the fault"
        cause = self._rig.link_statistics().cause or "nothing unusual"
        return (
            f"host or line stood still (last record of the link: {cause}); clear the fault, relieve the host "
            "or allow a longer lease"
        )

    def _raise_fault(self) -> None:
        """Raise the fault with its text; the event that names it may come a little after the samples that show it."""
        status = self._rig.status
        faults = self._faults or (status.faults if status else 0)
        self._tripped_s = self._tripped_s or time.monotonic()
        if faults or time.monotonic() - self._tripped_s > _FAULT_TEXT_S:
            raise fault_error(faults, self._rig.dictionary, self._fault_tick)


_TEXTS = {
    RecordEnd.DONE: "recorded to the end",
    RecordEnd.STOPPED: "stopped by the operator",
}
