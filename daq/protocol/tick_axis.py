"""From the 32-bit ticks of stream frames to one 64-bit time axis, with every missing sample counted.

Theory of operation. A stream frame says at which tick its first sample was taken; the axis knows which tick
should come next. Equal: nothing was lost. Ahead: samples are missing, and the difference says exactly how
many. Behind: the frame was received before (the line repeated it), or the controller's counter was set
back. The frame's sequence number tells the cases apart: it counts stream frames, so a jump of the tick that
the sequence number cannot explain is a jump of the counter itself, not a loss.

The axis never goes back: after a reboot or a counter set back, it goes on where it was, with a gap of
unknown length (0 missing samples) that names the cause. This file does not look at samples.
"""

from dataclasses import dataclass
from enum import Enum
from typing import Final

import numpy as np
from numpy.typing import NDArray

_WRAP: Final = 1 << 32


class GapCause(Enum):
    """Why samples are missing."""

    LOSS = "loss"
    REBOOT = "reboot"
    RECONNECT = "reconnect"
    TICK_JUMP = "tick_jump"


@dataclass(frozen=True, slots=True, kw_only=True)
class Gap:
    """A hole in the samples.

    Attributes:
        first_tick: Tick of the first missing sample, on the 64-bit axis.
        missing_samples: Number of missing samples; 0 when it cannot be known (reboot, counter set back).
        cause: Why they are missing.
    """

    first_tick: int
    missing_samples: int
    cause: GapCause


class TickAxis:
    """Places stream frames on the axis; `gaps` collects what was missing until `take_gaps`."""

    def __init__(self) -> None:
        self.divisor = 1
        self.repeated = 0
        """Frames dropped because their samples were received before."""
        self.missing_samples = 0
        """Samples known to be missing, all gaps together."""
        self._gaps: list[Gap] = []
        self._raw_next = 0  # tick on the wire that the next sample should have ...
        self._axis_next = 0  # ... and the same instant on the axis
        self._seq_next = 0
        self._frame_ticks = 0  # of the last frame; 0 before the first of a stream
        self._known = False  # some sample has been placed, so raw and axis belong together
        self._running = False  # the next frame must continue the last one
        self._broken_by: GapCause | None = None

    def take_gaps(self) -> tuple[Gap, ...]:
        """Return the gaps found since the last call."""
        gaps, self._gaps = tuple(self._gaps), []
        return gaps

    def start(self, tick: int) -> None:
        """Take note that the controller starts a stream whose first sample is at `tick`."""
        if self._running and self._broken_by is None and _signed(tick - self._raw_next) <= 0:
            return  # a repeated reply: the stream that it started is already flowing
        self._resume(tick)
        self._seq_next = self._frame_ticks = 0

    def stop(self, tick: int) -> None:
        """Take note that the stream has ended; its next sample would have been at `tick`."""
        if not self._running or self._broken_by is not None:
            return
        ahead = _signed(tick - self._raw_next)
        if ahead > 0:
            self._skip(ahead, GapCause.LOSS)
        self._running = False

    def break_off(self, cause: GapCause) -> None:
        """Take note that the link was set up anew; the gap up to the next sample is due to `cause`."""
        if self._running or self._broken_by is not None:
            self._broken_by = cause
        elif cause is GapCause.REBOOT:
            self._known = False  # another boot counts its ticks from zero

    def place(self, seqs: NDArray[np.uint8], ticks0: NDArray[np.uint32], batch: int) -> NDArray[np.int64]:
        """Return the axis tick of each frame's first sample, -1 for frames to be dropped.

        Args:
            seqs: Sequence numbers, shape (frames,).
            ticks0: Ticks on the wire of the first samples, shape (frames,).
            batch: Samples in each of these frames.
        """
        frame_ticks = batch * self.divisor
        steps = np.arange(len(ticks0), dtype=np.int64) * frame_ticks
        unbroken = self._running and self._broken_by is None
        if unbroken and np.array_equal(ticks0, (self._raw_next + steps) % _WRAP):
            first = self._axis_next
            self._advance(int(seqs[-1]), len(ticks0) * frame_ticks, frame_ticks)
            return first + steps
        places = [
            self._place_one(seq, tick, frame_ticks)
            for seq, tick in zip(seqs.tolist(), ticks0.tolist(), strict=True)
        ]
        return np.array(places, dtype=np.int64)

    def _place_one(self, seq: int, tick: int, frame_ticks: int) -> int:
        ahead = _signed(tick - self._raw_next)
        if self._broken_by is not None or not self._running:
            if self._broken_by is None and self._known and ahead < 0:
                self.repeated += 1  # from before the stop, where its samples count as received or missing
                return -1
            self._resume(tick)
            ahead = 0
        if ahead < 0 and (self._seq_next - 1 - seq) & 0xFF < 128:
            self.repeated += 1
            return -1
        if ahead:
            lost_frames = (seq - self._seq_next) & 0xFF
            step = self._frame_ticks or frame_ticks
            explained = ahead % step == 0 and (ahead // step) & 0xFF == lost_frames
            if ahead > 0:
                self._skip(ahead, GapCause.LOSS if explained else GapCause.TICK_JUMP)
            else:
                self._rebase(tick, GapCause.TICK_JUMP)
        first = self._axis_next
        self._advance(seq, frame_ticks, frame_ticks)
        return first

    def _resume(self, tick: int) -> None:
        """Make `tick` the next one expected: at a start, or at the first sign of life after a break."""
        cause, self._broken_by = self._broken_by, None
        if cause is not None:
            ahead = _signed(tick - self._raw_next)
            if cause is GapCause.REBOOT or ahead < 0:
                self._rebase(tick, cause)
            elif ahead > 0:
                self._skip(ahead, cause)
        elif self._known:
            # Between a stop and a start nothing is missing; nor does a counter set back turn the axis back.
            self._axis_next += max(0, _signed(tick - self._raw_next))
        else:
            self._axis_next = max(tick, self._axis_next)
        self._raw_next = tick
        self._known = self._running = True

    def _skip(self, ticks: int, cause: GapCause) -> None:
        missing = ticks // self.divisor
        self._gaps.append(Gap(first_tick=self._axis_next, missing_samples=missing, cause=cause))
        self.missing_samples += missing
        self._axis_next += ticks
        self._raw_next = (self._raw_next + ticks) % _WRAP

    def _rebase(self, tick: int, cause: GapCause) -> None:
        self._gaps.append(Gap(first_tick=self._axis_next, missing_samples=0, cause=cause))
        self._raw_next = tick

    def _advance(self, seq: int, ticks: int, frame_ticks: int) -> None:
        self._axis_next += ticks
        self._raw_next = (self._raw_next + ticks) % _WRAP
        self._seq_next = (seq + 1) & 0xFF
        self._frame_ticks = frame_ticks


def _signed(difference: int) -> int:
    """Difference of two 32-bit ticks as the shorter way round, in [-2^31, 2^31)."""
    return (difference + _WRAP // 2) % _WRAP - _WRAP // 2
