"""One joint's candidate fits on a cluster that loses a worker."""

from collections.abc import Callable
from concurrent.futures import Executor, Future
from pathlib import Path
from threading import Event
from typing import Any

import pytest

from daq.recording.store import read_recording
from discrepancy.model.reader import read_model
from discrepancy.workflow import GapOptions, run_gap
from server.services.cluster import ClusterPool
from server.services.workers import hold_one_thread
from tests.scaling.conftest import DaskProcesses
from tests.scaling.fleet_files import write_fleet


class KillingPool(Executor):
    """Hands tasks on, and calls `kill` when the fifth is done."""

    def __init__(self, pool: Executor, kill: Callable[[], None]) -> None:
        self._pool, self._kill, self.done = pool, kill, 0

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Hand on.  Any: the signature of Executor."""
        future = self._pool.submit(fn, *args, **kwargs)
        future.add_done_callback(self._count)
        return future

    def _count(self, _: Future[Any]) -> None:
        self.done += 1
        if self.done == 5:
            self._kill()


@pytest.mark.slow
def test_candidate_fits_on_a_cluster_that_loses_a_worker_give_the_same_answer(
    tmp_path: Path, dask_processes: DaskProcesses
) -> None:
    write_fleet(tmp_path)
    model = read_model(tmp_path / "model.yaml")
    train, test = ([read_recording(tmp_path / name)] for name in ("rough1.parquet", "rough11.parquet"))
    hold_one_thread()
    alone = run_gap(model, train, test)
    with ClusterPool(dask_processes.address, lambda _: None, Event()) as pool:
        spread = run_gap(
            model, train, test, GapOptions(executor=KillingPool(pool, dask_processes.workers[0].kill))
        )
        assert dask_processes.workers[0].wait() != 0
    assert spread.to_dict() == alone.to_dict()
    # Every candidate of a round needs the same data; they travel once for all of them.
    assert pool.spared_bytes > 2 * pool.shipped_bytes
