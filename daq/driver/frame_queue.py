"""Bounded queue of stream frames between the reader thread and the task that handles the data."""

import threading
from collections import deque
from collections.abc import Sequence


class FrameQueue:
    """Batches of frames, oldest first; a batch that does not fit is dropped whole and counted.

    The journal has every frame already, so a drop costs the live view, never the recording.
    """

    def __init__(self, max_frames: int) -> None:
        self._max_frames = max_frames
        self._batches: deque[Sequence[bytes]] = deque()
        self._frames = 0
        self._changed = threading.Condition()
        self.dropped_frames = 0

    def put(self, frames: Sequence[bytes]) -> None:
        """Append a batch; never waits."""
        with self._changed:
            if self._frames + len(frames) > self._max_frames:
                self.dropped_frames += len(frames)
                return
            self._batches.append(frames)
            self._frames += len(frames)
            self._changed.notify()

    def wait(self, timeout_s: float) -> None:
        """Wait until there are frames, `poke` is called, or the time is over."""
        with self._changed:
            if not self._batches:
                self._changed.wait(timeout_s)

    def take(self) -> list[bytes]:
        """Return all frames that are there."""
        with self._changed:
            frames = [frame for batch in self._batches for frame in batch]
            self._batches.clear()
            self._frames = 0
        return frames

    def poke(self) -> None:
        """Let a waiting `wait` return: something other than frames wants the data task's attention."""
        with self._changed:
            self._changed.notify_all()
