"""Processes for work that fans out, with a word now and then on how far it is."""

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from typing import ParamSpec, TypeVar

from server.errors import CampaignStoppedError

P = ParamSpec("P")
R = TypeVar("R")
TELL_EVERY_S = 5.0
# Each process works on small matrices; several threads in each would only wait for each other.
ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def usable_cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _begin_worker() -> None:
    """Leave Ctrl-C to the parent, which cancels what has not begun, and end when the parent is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


class WorkerPool(Executor):
    """A process pool that counts what is done; use as a context manager.

    The processes come from a fork server that has imported `preload` once, so that none of them imports it again;
    compiled kernels come from numba's cache on disk, which the parent filled with its own first call.
    """

    def __init__(self, jobs: int, preload: str, tell: Callable[[str], None], stop: threading.Event) -> None:
        """Prepare the pool; processes start with the first task.

        Args:
            jobs: number of processes.
            preload: module that the tasks live in.
            tell: takes a line every few seconds.
            stop: once set, no further task is taken.
        """
        for name, value in ONE_THREAD.items():
            os.environ.setdefault(name, value)  # read by the libraries that the fork server loads
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload([preload])
        self._pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_begin_worker)
        self._tell, self._stop = tell, stop
        self._lock = threading.Lock()
        self._done, self._started_s, self._told_s = 0, time.monotonic(), time.monotonic()

    def submit(self, fn: Callable[P, R], /, *args: P.args, **kwargs: P.kwargs) -> Future[R]:
        """Hand one task to the processes.

        Raises:
            CampaignStoppedError: a stop was asked for.
        """
        if self._stop.is_set():
            raise CampaignStoppedError("stopped while analysing; the recordings are whole")
        future = self._pool.submit(fn, *args, **kwargs)
        future.add_done_callback(self._count)
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes."""
        self._pool.shutdown(wait, cancel_futures=True)

    def _count(self, future: Future[R]) -> None:
        with self._lock:
            self._done += 1
            now_s = time.monotonic()
            if now_s - self._told_s < TELL_EVERY_S:
                return
            self._told_s = now_s
            line = f"  {self._done} fits of candidate effects done after {now_s - self._started_s:.0f} s"
        self._tell(line)
