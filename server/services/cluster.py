"""A Dask cluster for work that fans out: `jointscope gap --cluster tcp://HOST:PORT` (extra `cluster`).

Theory of operation. Tasks arrive as `partial(function, big, arrays)` with a small item each. The partial is pickled,
named by its hash and sent to the scheduler once, as the argument of a task that unpickles it; the real tasks name that
task's result. Workers so fetch it once each, and from one another. It is a computed result and not scattered data, so
the scheduler can make it again when the worker that held it dies; tasks and results of a lost worker are computed
again likewise. The functions are pure, so running one twice changes nothing.
"""

import hashlib
import importlib.metadata
import logging
import pickle
import socket
import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping
from concurrent.futures import Executor, Future
from functools import partial
from typing import Any, ParamSpec, TypeVar

from server.errors import InputError, RunFailedError
from server.services.tally import Tally
from server.services.workers import hold_one_thread, refuse_after_stop

P = ParamSpec("P")
R = TypeVar("R")
CONNECT_S = 10.0
EMPTY_CLUSTER_S = 60.0
"""So long may a cluster be without a worker, while they restart; then the run fails with a word."""
KEPT_SHIPMENTS = 4
PACKAGES = ("jointscope", "numpy", "scipy", "numba")


class ClusterPool(Executor):
    """Hands tasks to the workers of a Dask scheduler; use as a context manager.

    Attributes:
        shipped_bytes: pickled functions and arguments sent so far.
        spared_bytes: what sending them with every task would have added.
        tasks: tasks sent so far.
        slots: how many run at a time.
    """

    def __init__(self, address: str, tell: Callable[[str], None], stop: threading.Event) -> None:
        """Connect.

        Args:
            address: of the scheduler, `tcp://HOST:PORT`.
            tell: takes a line every few seconds.
            stop: once set, no further task is taken.

        Raises:
            InputError: Dask is not installed here, nobody answers, or the workers lack this program.
        """
        self._client = _connect(address)
        self._address, self._stop, self._tally = address, stop, Tally(tell)
        self._shipments: OrderedDict[str, Any] = OrderedDict()  # Any: Dask's futures are untyped
        self._open: set[Future[Any]] = set()
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._lost: RunFailedError | None = None
        self.shipped_bytes, self.spared_bytes, self.tasks = 0, 0, 0
        try:
            self.slots = _check_workers(self._client, address)
        except InputError:
            self._client.close()
            raise
        # Submitted one by one and never deduplicated: equal tasks are rare, hashing every argument is not free.
        self._executor = self._client.get_executor(pure=False)
        self._watcher = threading.Thread(target=self._watch, name="cluster-watch", daemon=True)
        self._watcher.start()

    def submit(self, fn: Callable[P, R], /, *args: P.args, **kwargs: P.kwargs) -> Future[R]:
        """Hand one task to the cluster.

        Raises:
            CampaignStoppedError: a stop was asked for.
            RunFailedError: the cluster is gone.
        """
        refuse_after_stop(self._stop)
        if self._lost is not None:
            raise RunFailedError(str(self._lost))
        item = pickle.dumps((args, kwargs), protocol=5)
        shared = self._ship(fn)
        self.tasks += 1
        self.shipped_bytes += len(item)
        inner = self._executor.submit(run_task, shared, item)
        promise: Future[R] = Future()
        with self._lock:
            self._open.add(promise)
        promise.add_done_callback(self._tally.count)
        promise.add_done_callback(lambda one: inner.cancel() if one.cancelled() else None)
        inner.add_done_callback(partial(self._settle, promise))
        return promise

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Leave the cluster; what it has not begun is cancelled, its processes stay."""
        self._ended.set()
        self._watcher.join()
        self._executor.shutdown(wait=False)
        self._shipments.clear()
        self._client.close()

    def _ship(self, fn: Callable[..., object]) -> Any:  # Any: a Dask future
        """Return the cluster's copy of a function and its bound arguments, sent if it is not there yet."""
        content = pickle.dumps(fn, protocol=5)
        key = f"jointscope-{hashlib.sha256(content).hexdigest()}"
        if key not in self._shipments:
            self._shipments[key] = self._client.submit(load_shipment, content, key=key)
            self.shipped_bytes += len(content)
        else:
            self.spared_bytes += len(content)
        self._shipments.move_to_end(key)
        while len(self._shipments) > KEPT_SHIPMENTS:
            self._shipments.popitem(last=False)  # the scheduler keeps it as long as a task needs it
        return self._shipments[key]

    def _take(self, promise: Future[Any]) -> bool:
        """Say whether the caller may settle this promise: nobody has, and nobody cancelled it."""
        with self._lock:
            ours = promise in self._open
            self._open.discard(promise)
        return ours and promise.set_running_or_notify_cancel()

    def _settle(self, promise: Future[R], inner: Future[R]) -> None:
        if not self._take(promise):
            return
        if inner.cancelled():
            promise.set_exception(
                RunFailedError(f"the scheduler {self._address} is gone, and its tasks with it")
            )
            return
        error = inner.exception()
        if error is None:
            promise.set_result(inner.result())
        elif type(error).__name__ == "KilledWorker":
            promise.set_exception(
                RunFailedError(f"several workers of {self._address} died over one task: {error}")
            )
        else:
            promise.set_exception(error)

    def _watch(self) -> None:
        """Fail what is open when the cluster stays without workers: nobody would ever do it."""
        empty_s = 0.0
        while not self._ended.wait(1.0):
            empty_s = 0.0 if _thread_count(self._client) else empty_s + 1.0
            if empty_s >= EMPTY_CLUSTER_S:
                self._give_up()
                return

    def _give_up(self) -> None:
        self._lost = error = RunFailedError(
            f"the cluster {self._address} has had no worker for {EMPTY_CLUSTER_S:.0f} s; start workers "
            f"(dask worker {self._address} --nthreads 1) and run again"
        )
        for promise in list(self._open):
            if self._take(promise):
                promise.set_exception(error)


def load_shipment(content: bytes) -> Callable[..., object]:
    """Unpickle a function with its bound arguments; runs on a worker."""
    found: Callable[..., object] = pickle.loads(content)
    return found


def run_task(function: Callable[..., object], item: bytes) -> object:
    """Apply a shipped function to one item; runs on a worker."""
    hold_one_thread()
    args, kwargs = pickle.loads(item)
    return function(*args, **kwargs)


def versions() -> dict[str, str]:
    """Return what must be the same on both sides for the same answer; runs on a worker."""
    return {name: importlib.metadata.version(name) for name in PACKAGES}


def _connect(address: str) -> Any:  # Any: distributed ships no types
    try:
        import distributed
        from distributed.comm.addressing import get_address_host_port
    except ImportError as error:
        raise InputError(
            "--cluster needs Dask, which is not installed here; install the extra: pip install 'jointscope[cluster]'"
        ) from error
    logging.getLogger("distributed").setLevel(logging.ERROR)  # its warnings would break into our lines
    client: Any = distributed.Client  # untyped
    try:
        # Dask tries for long and leaves threads behind where nobody listens: knock first.
        socket.create_connection(get_address_host_port(address), CONNECT_S).close()
        return client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise InputError(
            f"--cluster {address}: no Dask scheduler answers there; start one (dask scheduler --host HOST --port "
            "8786) and give its address as tcp://HOST:8786"
        ) from error


def _thread_count(client: Any) -> int:  # Any: a Dask client
    """Return how many tasks the cluster runs at a time."""
    try:
        threads: Mapping[str, int] = client.nthreads()
    except (OSError, RuntimeError):
        return 0
    return sum(threads.values())


def _check_workers(client: Any, address: str) -> int:  # Any: a Dask client
    """Return the number of threads of the workers, which must have this program in the same versions."""
    try:
        client.wait_for_workers(1, timeout=CONNECT_S)
    except TimeoutError as error:
        raise InputError(
            f"--cluster {address}: the scheduler has no worker; start some: dask worker {address} --nthreads 1"
        ) from error
    found = client.run(versions, on_error="return")
    for worker, answer in found.items():
        _compare_versions(worker, answer)
    return max(1, _thread_count(client))


def _compare_versions(worker: str, answer: object) -> None:
    if not isinstance(answer, dict):
        raise InputError(
            f"--cluster: worker {worker} cannot run this program ({answer}); install jointscope[cluster] in its "
            "environment"
        )
    here = versions()
    different = [
        f"{name} {answer[name]} instead of {here[name]}" for name in PACKAGES if answer[name] != here[name]
    ]
    if different:
        raise InputError(
            f"--cluster: worker {worker} has {', '.join(different)}: its answers would differ; install the same "
            "versions there (constraints.txt)"
        )
