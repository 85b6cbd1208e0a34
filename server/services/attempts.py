"""How many wrong tokens an address may send: nobody guesses 256 bits, but trying costs us and fills logs."""

import threading
import time
from collections import OrderedDict
from collections.abc import Callable

PER_S = 60.0
_MAX_ADDRESSES = 10_000


class FailedAttempts:
    """Counts wrong tokens by address, in a bucket that runs empty within a minute.

    A right token is never refused here, whoever else sits behind the same address: e-stop must work.

    Args:
        allowed: wrong tokens a minute.
        clock: monotonic time, s.
    """

    def __init__(self, allowed: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._allowed = allowed
        self._clock = clock
        self._lock = threading.Lock()
        self._buckets: OrderedDict[str, tuple[float, float]] = OrderedDict()

    def note(self, address: str) -> float:
        """Count a wrong token and return how long to wait before the next, s; 0 while there are few."""
        now_s = self._clock()
        with self._lock:
            level, then_s = self._buckets.pop(address, (0.0, now_s))
            level = max(0.0, level - (now_s - then_s) * self._allowed / PER_S) + 1.0
            self._buckets[address] = min(level, 2.0 * self._allowed), now_s
            if len(self._buckets) > _MAX_ADDRESSES:
                self._buckets.popitem(last=False)
        return max(0.0, level - self._allowed) * PER_S / self._allowed
