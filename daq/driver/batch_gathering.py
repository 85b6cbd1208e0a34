"""Lets the data task handle samples in batches of some 30 ms where they come in real time."""

import math
import time
from collections.abc import Callable

BATCH_S = 0.03
"""Three frames at 2.5 kHz: a third of the wake-ups, and still a quarter of the time that a half of set-points lasts."""
_PACE_TIME_S = 0.2
_PAUSE_IN_STREAM_S = 1.0
"""After a longer pause the stream was stopped in between: that says nothing of the pace."""
_FASTER_THAN_LIFE = 2.0


class BatchGathering:
    """Waits for more samples unless they come faster than real time.

    An emulated controller at full speed waits for our keep-alives; there every pause would cost throughput.

    Args:
        tick_hz: Controller ticks per second.
        clock: Monotonic time, s.
        sleep: Waits so many seconds.
    """

    def __init__(
        self,
        tick_hz: int,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._tick_hz = tick_hz
        self._clock = clock
        self._sleep = sleep
        self._seen_tick = 0
        self._seen_s = clock()
        self._paused_s = clock()
        self._pace = math.inf  # unknown: a pause too few costs less than one too many

    def pause(self) -> None:
        """Wait until `BATCH_S` have passed since the last pause, if samples come in real time."""
        left_s = self._paused_s + BATCH_S - self._clock()
        if left_s > 0.0 and self._pace < _FASTER_THAN_LIFE:
            self._sleep(left_s)
        self._paused_s = self._clock()

    def note_samples(self, tick: int) -> None:
        """Take note of the newest tick; the pace is controller time per host time over some 0.2 s."""
        now_s = self._clock()
        elapsed_s = now_s - self._seen_s
        if elapsed_s < _PACE_TIME_S:
            return
        if elapsed_s < _PAUSE_IN_STREAM_S:
            self._pace = (tick - self._seen_tick) / self._tick_hz / elapsed_s
        self._seen_tick, self._seen_s = tick, now_s
