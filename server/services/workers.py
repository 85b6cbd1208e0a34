"""Processes of this machine for work that fans out; a process that dies takes nothing with it.

Theory of operation. `WorkerPool` keeps a `ProcessPoolExecutor`. When one of its processes is killed (out of memory, an
operator), Python declares the whole pool broken and every task in it failed, though nobody knows which of them was to
blame. The pool is then replaced, and the lost tasks run again one at a time, each in a process of its own: a task that
ends its process there too is the culprit, and only that one fails.
"""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Generic, ParamSpec, TypeVar

from server.errors import CampaignStoppedError, RunFailedError
from server.services.tally import Tally

P = ParamSpec("P")
R = TypeVar("R")
# Each process works on small matrices; several threads in each would only wait for each other.
ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def usable_cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def hold_one_thread() -> None:
    """Let this process's linear algebra use one thread from now on, so that sums come out the same everywhere."""
    from threadpoolctl import threadpool_limits

    threadpool_limits(1)


def child_environment() -> dict[str, str]:
    """Return the environment for a process that runs a module of ours, whatever folder it runs in."""
    root = str(Path(__file__).resolve().parents[2])
    known = [part for part in os.environ.get("PYTHONPATH", "").split(os.pathsep) if part]
    return {**os.environ, **ONE_THREAD, "PYTHONPATH": os.pathsep.join([root, *known])}


def _begin_worker() -> None:
    """Leave Ctrl-C to the parent, which cancels what has not begun, and end when the parent is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    hold_one_thread()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Task(Generic[R]):
    call: Callable[[], R]
    promise: Future[R]

    def settle(self, done: Future[R]) -> None:
        """Hand on what a process returned or raised."""
        if not self.promise.set_running_or_notify_cancel():
            return
        error = done.exception()
        if error is None:
            self.promise.set_result(done.result())
        else:
            self.promise.set_exception(error)


class WorkerPool(Executor):
    """A process pool that counts what is done and outlives its processes; use as a context manager.

    The processes come from a fork server that has imported `preload` once, so that none of them imports it again;
    compiled kernels come from numba's cache on disk, which the parent filled with its own first call.

    Attributes:
        slots: how many tasks run at a time.
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
        self._context = multiprocessing.get_context("forkserver")
        self._context.set_forkserver_preload([preload])
        self.slots, self._stop, self._tally = jobs, stop, Tally(tell)
        self._lock, self._closed = threading.Lock(), False
        self._pool = self._new_pool(jobs)
        self._retired: list[ProcessPoolExecutor] = []
        self._alone = ThreadPoolExecutor(1, thread_name_prefix="retry")

    def submit(self, fn: Callable[P, R], /, *args: P.args, **kwargs: P.kwargs) -> Future[R]:
        """Hand one task to the processes.

        Raises:
            CampaignStoppedError: a stop was asked for.
        """
        refuse_after_stop(self._stop)
        task = _Task(call=partial(fn, *args, **kwargs), promise=Future[R]())
        task.promise.add_done_callback(self._tally.count)
        pool, inner = self._hand_over(task)
        task.promise.add_done_callback(lambda promise: inner.cancel() if promise.cancelled() else None)
        inner.add_done_callback(partial(self._finish, task, pool))
        return task.promise

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes; tasks that have not begun are cancelled."""
        self._closed = True
        self._alone.shutdown(wait, cancel_futures=True)
        for pool in (*self._retired, self._pool):
            pool.shutdown(wait, cancel_futures=True)

    def _new_pool(self, jobs: int) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(jobs, mp_context=self._context, initializer=_begin_worker)

    def _hand_over(self, task: _Task[R]) -> tuple[ProcessPoolExecutor, Future[R]]:
        pool = self._pool
        try:
            return pool, pool.submit(task.call)
        except BrokenProcessPool:
            pool = self._replace(pool)
            return pool, pool.submit(task.call)

    def _replace(self, broken: ProcessPoolExecutor) -> ProcessPoolExecutor:
        """Return the pool that takes the broken one's place; the first that asks makes it."""
        with self._lock:
            if self._pool is broken:
                self._retired.append(broken)  # ended later: this may be its own thread
                self._pool = self._new_pool(self.slots)
            return self._pool

    def _finish(self, task: _Task[R], pool: ProcessPoolExecutor, inner: Future[R]) -> None:
        if inner.cancelled():
            task.promise.cancel()
            task.promise.set_running_or_notify_cancel()
        elif isinstance(inner.exception(), BrokenProcessPool) and not self._closed:
            self._replace(pool)
            self._alone.submit(self._try_alone, task)
        else:
            task.settle(inner)

    def _try_alone(self, task: _Task[R]) -> None:
        """Run a task again whose process died, where it can harm no other."""
        again: Future[R] = Future()
        with self._new_pool(1) as pool:
            try:
                again.set_result(pool.submit(task.call).result())
            except BrokenProcessPool:
                again.set_exception(
                    RunFailedError(
                        "the process working on this was killed twice (out of memory?); give it more memory or "
                        "use fewer --jobs"
                    )
                )
            except Exception as error:  # noqa: BLE001  # whatever the task raised is the caller's
                again.set_exception(error)
        task.settle(again)


def refuse_after_stop(stop: threading.Event) -> None:
    """Take no further task once a stop was asked for.

    Raises:
        CampaignStoppedError: it was.
    """
    if stop.is_set():
        raise CampaignStoppedError("stopped while analysing; the recordings are whole")
