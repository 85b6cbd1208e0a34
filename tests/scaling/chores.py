"""Work for other processes: functions that they can import."""

import os
import signal
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray


def inner_product(weights: NDArray[np.float64], seed: int) -> float:
    """Return a number whose last digit depends on the order of its sums, after a little while."""
    time.sleep(0.05)
    values = np.random.default_rng(seed).normal(size=weights.size)
    return float(weights @ values + np.linalg.norm(np.outer(values[:200], weights[:200]) @ values[:200]))


def process_id(_: int) -> int:
    """Return the process that does this."""
    time.sleep(0.02)
    return os.getpid()


def die_once(marker: Path, item: int) -> int:
    """End the own process the first time that any process comes here with item 3."""
    if item == 3 and not marker.exists():
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return item * item


def die_always(item: int) -> int:
    """End the own process for item 3."""
    if item == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return item * item
