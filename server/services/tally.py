"""Says now and then how far a fan-out is."""

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

TELL_EVERY_S = 5.0


class Tally:
    """Counts finished tasks and tells the number every few seconds."""

    def __init__(self, tell: Callable[[str], None]) -> None:
        self._tell = tell
        self._lock = threading.Lock()
        self._done, self._started_s = 0, time.monotonic()
        self._told_s = self._started_s

    def count(self, _: Future[Any]) -> None:  # Any: whatever the tasks return
        """Take one more task as done; called from any thread."""
        with self._lock:
            self._done += 1
            now_s = time.monotonic()
            if now_s - self._told_s < TELL_EVERY_S:
                return
            self._told_s = now_s
            line = f"  {self._done} fits of candidate effects done after {now_s - self._started_s:.0f} s"
        self._tell(line)
