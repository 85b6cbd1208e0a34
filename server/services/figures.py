"""Figures that services count for /metrics, where nobody else keeps them."""

import threading


class Counter:
    """A number that only goes up."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self.value = 0

    def add(self, count: int = 1) -> None:
        """Count."""
        with self._lock:
            self.value += count


class Durations:
    """How often something was done and how long it took, s."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self.count = 0
        self.total_s = 0.0
        self.longest_s = 0.0

    def observe(self, seconds: float) -> None:
        """Take one."""
        with self._lock:
            self.count += 1
            self.total_s += seconds
            self.longest_s = max(self.longest_s, seconds)


class Figures:
    """Counters of one process; see the head of this file."""

    def __init__(self) -> None:
        self.frames_sent = Counter()
        self.samples_dropped = Counter()
        self.viewers_given_up = Counter()
        self.tokens_refused = Counter()
