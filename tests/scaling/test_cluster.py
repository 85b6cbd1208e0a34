"""The Dask cluster against real processes, one of which dies in mid-run."""

import sys
from functools import partial
from threading import Event

import numpy as np
import pytest

from server.errors import InputError, RunFailedError
from server.services.cluster import ClusterPool
from server.services.workers import hold_one_thread
from tests.scaling.chores import inner_product, process_id
from tests.scaling.conftest import DaskProcesses

WEIGHTS = np.random.default_rng(0).normal(size=100_000)


def ignore(_: str) -> None:
    """Take a line and drop it."""


def test_a_killed_worker_changes_no_digit_and_loses_nothing(dask_processes: DaskProcesses) -> None:
    hold_one_thread()  # two threads of linear algebra add in another order
    chore = partial(inner_product, WEIGHTS)
    with ClusterPool(dask_processes.address, ignore, Event()) as pool:
        ids = set(pool.map(process_id, range(20)))
        assert ids == {worker.pid for worker in dask_processes.workers}
        found = pool.map(chore, range(60))
        first = [next(found) for _ in range(10)]
        dask_processes.workers[0].kill()
        rest = list(found)
        ids_after = set(pool.map(process_id, range(10)))
    assert ids_after == {dask_processes.workers[1].pid}
    assert first + rest == [chore(seed) for seed in range(60)]
    # 60 tasks share one shipment of 800,040 bytes; each adds its own item and no array.
    assert pool.shipped_bytes < WEIGHTS.nbytes + 60 * 200 + 20_000


def test_an_error_of_a_task_arrives_as_it_was_raised(dask_processes: DaskProcesses) -> None:
    with (
        ClusterPool(dask_processes.address, ignore, Event()) as pool,
        pytest.raises(ValueError, match="math domain error|nonnegative"),
    ):
        list(pool.map(__import__("math").sqrt, [1.0, -1.0]))


def test_a_cluster_whose_workers_are_gone_fails_with_a_word(
    dask_processes: DaskProcesses, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.services.cluster.EMPTY_CLUSTER_S", 1.0)
    with ClusterPool(dask_processes.address, ignore, Event()) as pool:
        found = pool.map(partial(inner_product, WEIGHTS), range(200))
        for worker in dask_processes.workers:
            worker.kill()
        with pytest.raises(RunFailedError, match="has had no worker for .* start workers"):
            list(found)


def test_a_scheduler_that_is_not_there_is_named_with_the_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    monkeypatch.setattr("server.services.cluster.CONNECT_S", 0.5)
    with pytest.raises(InputError, match="no Dask scheduler answers there; start one"):
        ClusterPool("tcp://127.0.0.1:9", ignore, Event())


def test_an_address_that_is_none_is_refused() -> None:
    pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    with pytest.raises(InputError, match="no Dask scheduler answers there"):
        ClusterPool("nonsense://x", ignore, Event())


def test_without_the_extra_the_message_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match="install the extra"):
        ClusterPool("tcp://127.0.0.1:9", ignore, Event())
