"""The data task of one rig: a thread that opens it, pulls its samples, and does one piece of work at a time.

Theory of operation. The driver wants one task that calls `next_blocks` and `keep_alive`; here it is this thread.
Idle, it pulls whatever comes and gives it to the viewers' fan-out; work (a recording of a session, a campaign's
step) is handed over by `perform` and runs *in* this thread with the open rig, so that it becomes the data task for
as long as it lasts. Questions to the controller (parameters, e-stop) may come from any thread and go to `driver`
directly.
"""

import contextlib
import logging
import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Generic, TypeVar

from daq.driver.options import StreamPlan
from daq.driver.rig import Rig as DriverRig
from daq.errors import DaqError, LinkTimeoutError, PortError
from daq.protocol.codes import DriveState
from daq.protocol.stream import SampleBlock
from server.config.rig import Rig
from server.services.errors import BusyError, ConflictError
from server.services.rig_access import RigHooks, connected_rig
from server.services.rigs.fanout import Fanout

_LOG = logging.getLogger(__name__)
T = TypeVar("T")
_PULL_S = 0.05
_STREAM_AGAIN_S = 2.0
MOVING = (DriveState.ARMED, DriveState.RUNNING, DriveState.RAMPING)


class ConnectionState(StrEnum):
    """Where the connection to a rig stands."""

    DISCONNECTED = "disconnected"
    CONNECTING = "connecting"
    CONNECTED = "connected"
    LOST = "lost"
    FAILED = "failed"


@dataclass(frozen=True, slots=True, kw_only=True)
class RigJob(Generic[T]):
    """Work on an open rig.

    Attributes:
        title: for people: what the rig is busy with.
        run: the work; gets the open rig and must end soon after `stop` is set, with the drive at rest.
        stop: set to end the work early.
    """

    title: str
    run: Callable[[DriverRig], T]
    stop: threading.Event


class _Handed(Generic[T]):
    """A job with the future of its result."""

    def __init__(self, job: RigJob[T]) -> None:
        self.job = job
        self.future: Future[T] = Future()

    def run(self, driver: DriverRig) -> None:
        if not self.future.set_running_or_notify_cancel():
            return
        try:
            self.future.set_result(self.job.run(driver))
        except BaseException as error:  # noqa: BLE001  # whoever handed the job over gets it
            self.future.set_exception(error)


class RigWorker:
    """Thread, connection and work of one rig.

    Args:
        rig: its file's content.
        path: the file, for messages.
        hooks: asked and told by the driver.
        samples: gets every block.
    """

    def __init__(self, rig: Rig, path: Path, hooks: RigHooks, samples: Fanout[SampleBlock]) -> None:
        self._rig = rig
        self._path = path
        self._hooks = hooks
        self._samples = samples
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._jobs: queue.SimpleQueue[_Handed[object]] = queue.SimpleQueue()
        self._current: RigJob[object] | None = None
        self._closing = threading.Event()
        self._settled = threading.Event()
        self._driver: DriverRig | None = None
        self._streaming = False
        self._stream_after_s = 0.0
        self.failure: Exception | None = None
        self.notes: list[str] = []

    @property
    def connection(self) -> ConnectionState:
        """Where the connection stands."""
        driver = self._driver
        if driver is not None:
            return ConnectionState.CONNECTED if driver.link_up else ConnectionState.LOST
        if self._thread is not None and self._thread.is_alive():
            return ConnectionState.CONNECTING
        return ConnectionState.FAILED if self.failure is not None else ConnectionState.DISCONNECTED

    @property
    def driver(self) -> DriverRig:
        """The open rig.

        Raises:
            ConflictError: it is not connected.
        """
        driver = self._driver
        if driver is None:
            raise self._not_open()
        return driver

    @property
    def open_driver(self) -> DriverRig | None:
        """The open rig, None when it is not connected."""
        return self._driver

    @property
    def busy_with(self) -> str | None:
        """What the rig is at work on, None when it is not."""
        job = self._current
        return None if job is None else job.title

    def start(self) -> None:
        """Begin to connect, unless connected or connecting already."""
        with self._lock:
            if self._thread is not None and self._thread.is_alive():
                return
            self._closing.clear()
            self._settled.clear()
            self.failure, self.notes = None, []
            self._thread = threading.Thread(target=self._run, name=f"jointscope-rig-{self._rig.name}")
            self._thread.start()

    def wait_connected(self, timeout_s: float) -> None:
        """Wait until the connection stands, has failed, or the time is over.

        Raises:
            Exception: what it failed with.
        """
        self._settled.wait(timeout_s)
        if self.failure is not None:
            raise self.failure

    def perform(self, job: RigJob[T]) -> "Future[T]":
        """Hand over work; it begins within a twentieth of a second.

        Raises:
            ConflictError: the rig is not connected.
            BusyError: it is at work already.
        """
        handed = _Handed(job)
        with self._lock:
            if self._driver is None or self._closing.is_set():
                raise self._not_open()
            if self._current is not None:
                raise BusyError(
                    f"rig {self._rig.name} is busy with {self._current.title}", "wait for its end, or stop it"
                )
            self._current = job  # type: ignore[assignment]  # a queue holds jobs of every kind of result
        self._jobs.put(handed)  # type: ignore[arg-type]  # the same
        return handed.future

    def come_to_rest(self, timeout_s: float = 10.0) -> None:
        """Stop what the rig is at, switch the drive off, and return when it rests.

        Raises:
            ConflictError: it does not come to rest in time; e-stop is what is left.
        """
        deadline_s = time.monotonic() + timeout_s
        while (job := self._current) is not None:
            job.stop.set()
            if time.monotonic() > deadline_s:
                raise ConflictError(
                    f"rig {self._rig.name} did not stop {job.title} within {timeout_s:g} s", "press e-stop"
                )
            time.sleep(0.01)
        driver = self._driver
        if driver is None or not driver.armed:
            return
        with contextlib.suppress(PortError, LinkTimeoutError):  # then the controller's lease stops the drive
            driver.disarm()
            known = driver.status  # may be older than the disarm
            while driver.link_up and time.monotonic() < deadline_s:
                if driver.status is not known and not _is_moving(driver):
                    return
                time.sleep(0.01)

    def close(self) -> None:
        """Bring the rig to rest and give its port back; returns when that is done."""
        thread = self._thread
        if thread is None:
            return
        with contextlib.suppress(ConflictError, DaqError):  # closing the port lets the drive's lease run out
            self.come_to_rest()
        self._closing.set()
        thread.join()

    def _not_open(self) -> ConflictError:
        state = self.connection
        remedy = "wait until it is" if state is ConnectionState.CONNECTING else "connect it first"
        return ConflictError(f"rig {self._rig.name} is {state}", remedy)

    def _run(self) -> None:
        try:
            with connected_rig(self._rig, self._path, self.notes.append, self._hooks) as driver:
                self._driver = driver
                self._settled.set()
                try:
                    self._serve(driver)
                finally:
                    self._driver = None
        except Exception as error:  # noqa: BLE001  # outermost loop: the rig's view tells it
            _LOG.warning("rig %s: %s", self._rig.name, error)
            self.failure = error
        finally:
            self._give_up_jobs()
            self._settled.set()

    def _serve(self, driver: DriverRig) -> None:
        self._streaming = False
        while not self._closing.is_set():
            try:
                handed = self._jobs.get_nowait()
            except queue.Empty:
                self._idle(driver)
                continue
            try:
                handed.run(driver)
            finally:
                self._streaming = False
                self._current = None

    def _idle(self, driver: DriverRig) -> None:
        self._stream_for_viewers(driver)
        self.publish(driver.next_blocks(_PULL_S))
        driver.events()  # told by the hook already
        driver.keep_alive()

    def publish(self, blocks: list[SampleBlock]) -> None:
        """Give blocks to the viewers; a job passes this as `on_blocks`."""
        for block in blocks:
            self._samples.publish(block)

    def _stream_for_viewers(self, driver: DriverRig) -> None:
        wanted = self._samples.subscribers > 0
        if wanted == self._streaming or not driver.link_up or time.monotonic() < self._stream_after_s:
            return
        try:
            if wanted:
                driver.start_stream(StreamPlan())
            else:
                driver.stop_stream()
            self._streaming = wanted
        except DaqError as error:
            self._stream_after_s = time.monotonic() + _STREAM_AGAIN_S
            _LOG.warning("rig %s: no stream for viewers: %s", self._rig.name, error)

    def _give_up_jobs(self) -> None:
        with self._lock:
            self._current = None
            while not self._jobs.empty():
                self._jobs.get_nowait().future.set_exception(
                    ConflictError(f"rig {self._rig.name} was disconnected", "connect it again")
                )


def _is_moving(driver: DriverRig) -> bool:
    status = driver.status
    return status is not None and status.state in MOVING
