"""Where work that fans out is done: processes of this machine, or a Dask cluster."""

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

from server.errors import InputError
from server.services.workers import WorkerPool, usable_cores

if TYPE_CHECKING:
    from server.services.cluster import ClusterPool


class Placement(Protocol):
    """What decides where work is done: every request that fans out has these."""

    @property
    def jobs(self) -> int | None:
        """Processes of this machine; None takes one for each core."""

    @property
    def cluster(self) -> str | None:
        """Address of a Dask scheduler that does the work instead."""

    @property
    def stop(self) -> threading.Event:
        """Set it to give up between two tasks."""


def open_executor(
    preload: str, tell: Callable[[str], None], placement: Placement
) -> "WorkerPool | ClusterPool":
    """Return the executor that a request asks for; use as a context manager.

    Args:
        preload: module that the tasks live in.
        tell: takes a line every few seconds.
        placement: processes or cluster.

    Raises:
        InputError: both are asked for, or the cluster cannot be used.
    """
    if placement.cluster is None:
        jobs = placement.jobs or usable_cores()
        tell(f"working on {jobs} {'process' if jobs == 1 else 'processes'}")
        return WorkerPool(jobs, preload, tell, placement.stop)
    if placement.jobs is not None:
        raise InputError("--jobs and --cluster exclude each other: a cluster's size is that of its workers")
    from server.services.cluster import ClusterPool

    pool = ClusterPool(placement.cluster, tell, placement.stop)
    tell(f"working on the cluster {placement.cluster} ({pool.slots} at a time)")
    return pool
