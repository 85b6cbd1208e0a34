"""Waiting reads on a file descriptor (serial port, pseudo-terminal, socket) that another thread can wake.

A paced serial line brings a frame octet by octet every 10 ms: waiting a few milliseconds after the first one saves a
hundred wake-ups. A line that had octets a moment ago is fast (an emulator at full speed, a backlog): waiting there
would only lower the throughput, because the sender waits for our keep-alives.
"""

import os
import select
import time
from collections.abc import Callable
from contextlib import suppress

_READ_LIMIT = 1 << 16


class DescriptorReader:
    """Reads one descriptor, which somebody else opens and closes.

    Args:
        descriptor: What to read.
        poll_s: Longest wait of one read, s.
        clock: Monotonic time, s.
    """

    def __init__(self, descriptor: int, poll_s: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._descriptor = descriptor
        self._poll_s = poll_s
        self._clock = clock
        self._last_read_s = clock()
        self._wake_end, self._wake_start = os.pipe()
        os.set_blocking(self._wake_start, False)

    def read(self, gather_s: float) -> bytes | None:
        """Wait for octets, see `Transport.read`.

        Returns:
            The octets; empty when none came, None when the other side has closed.

        Raises:
            OSError: The descriptor is gone.
        """
        ready, _, _ = select.select([self._descriptor, self._wake_end], [], [], self._poll_s)
        if self._wake_end in ready:
            os.read(self._wake_end, 4096)
        if self._descriptor not in ready:
            return b""
        if 0.0 < gather_s <= self._clock() - self._last_read_s:
            select.select([self._wake_end], [], [], gather_s)
        data = os.read(self._descriptor, _READ_LIMIT)
        self._last_read_s = self._clock()
        return data or None

    def wake(self) -> None:
        """Let a waiting `read` return, or the next one."""
        with suppress(BlockingIOError, OSError):  # full: a wake-up is under way already; closed: nobody waits
            os.write(self._wake_start, b"w")

    def close(self) -> None:
        """Close what this reader has opened, which is its wake-up pipe; more than once does no harm."""
        if self._wake_start >= 0:
            os.close(self._wake_start)
            os.close(self._wake_end)
        self._wake_start = self._wake_end = -1
