"""The process pool of this machine when its processes die."""

from functools import partial
from pathlib import Path
from threading import Event

import pytest

from server.errors import RunFailedError
from server.services.workers import WorkerPool
from tests.scaling.chores import die_always, die_once


def ignore(_: str) -> None:
    """Take a line and drop it."""


def test_a_killed_process_loses_nothing(tmp_path: Path) -> None:
    with WorkerPool(2, "math", ignore, Event()) as pool:
        assert list(pool.map(partial(die_once, tmp_path / "died"), range(12))) == [k * k for k in range(12)]
    assert (tmp_path / "died").exists()


def test_a_task_that_always_kills_its_process_fails_alone() -> None:
    with WorkerPool(2, "math", ignore, Event()) as pool:
        futures = [pool.submit(die_always, k) for k in range(6)]
        assert [futures[k].result() for k in (0, 1, 2, 4, 5)] == [0, 1, 4, 16, 25]
        with pytest.raises(RunFailedError, match="killed twice"):
            futures[3].result()
