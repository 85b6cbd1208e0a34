"""One job while it runs: a thread that plays the steps of a plan on a rig that it holds by a lease of its own.

Theory of operation. The thread plays step after step as `jointscope run` does; what pulls samples is handed to the
rig's data task, analyses run here. Requests (`ask`) come from other threads after the ledger has accepted them: they
set a wish and end the record under way, whose drive comes to rest before anything else. A paused record is put aside
and begun anew on resume: half an excitation is another experiment. Whatever ends the job, its lease is given back
before its last state is told, so that whoever waits for the end can have the rig at once.
"""

import contextlib
import logging
import threading
from collections.abc import Callable
from typing import TypeVar

from daq.driver.rig import Rig as DriverRig
from daq.recording.journal import JOURNAL_SUFFIX
from daq.recording.journal_reader import ARCHIVE_SUFFIX
from server.config.campaign import GapStep, IdentifyStep, RecordStep
from server.errors import CampaignStoppedError
from server.services.campaign import accounting, how_it_ended, new_manifest, play_step
from server.services.errors import ConflictError
from server.services.jobs.held_lease import HeldLease
from server.services.jobs.machine import Happening
from server.services.jobs.order import JobBook, JobOrder, JobProgress, JobWatch, KeepingListener
from server.services.manifest import Ended, Manifest, StepEntry
from server.services.plan import PlannedStep
from server.services.rigs.worker import RigJob
from server.services.run_folder import RECORDS
from server.services.steps import StepContext

_LOG = logging.getLogger(__name__)
T = TypeVar("T")
_HAPPENING_OF = {
    Ended.TRIPPED: Happening.TRIPPED,
    Ended.REFUSED: Happening.REFUSED,
    Ended.INTERRUPTED: Happening.CUT_OFF,
}


class JobRun:
    """The running job; `start` it once.

    Args:
        order: what to do.
        book: where it is written down.
    """

    def __init__(self, order: JobOrder, book: JobBook) -> None:
        self.order = order
        self.progress = JobProgress(steps=len(order.plan.steps))
        self._book = book
        self._wish: Happening | None = None
        self._cut_off = ""
        self._resumed = threading.Event()
        self._stop = threading.Event()
        self._step: PlannedStep | None = None
        self._lease: HeldLease | None = None
        self._thread = threading.Thread(target=self._run, name=f"jointscope-job-{order.id[:8]}", daemon=True)

    @property
    def alive(self) -> bool:
        """Whether the thread still runs."""
        return self._thread.is_alive()

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def join(self, timeout_s: float) -> None:
        """Wait for the end."""
        self._thread.join(timeout_s)

    def ask(self, happening: Happening) -> None:
        """Pause, resume, stop or abort; the ledger has accepted it."""
        if happening is Happening.RESUME:
            self._wish = None
            self._resumed.set()
            return
        self._wish = happening
        analysing = self._step is not None and isinstance(self._step.step, IdentifyStep | GapStep)
        if not (happening is Happening.PAUSE and analysing):  # an analysis is paused at its end
            self._stop.set()
        self._resumed.set()

    def cut_off(self, reason: str) -> None:
        """End the job because lease or service are gone."""
        self._cut_off = self._cut_off or reason
        self._stop.set()
        self._resumed.set()

    def _run(self) -> None:
        happening, reason = Happening.FAILED, ""
        try:
            happening, reason = self._hold_and_play()
        except BaseException as error:  # noqa: BLE001  # outermost loop of the job: its state tells it
            happening, reason = self._judge(error)
        try:
            self._book.happened(happening, reason)
        except ConflictError as error:
            _LOG.error("%s: %s", self.order.title, error)

    def _hold_and_play(self) -> tuple[Happening, str]:
        rig = self.order.rig
        rig.connect()
        with HeldLease(rig, self.order.who, self.cut_off) as lease:
            self._lease = lease
            self._book.happened(Happening.BEGUN, "")
            try:
                self._play()
            except BaseException as error:  # noqa: BLE001  # judged here, while the lease can still be asked
                return self._judge(error)
        return Happening.FINISHED, ""

    def _play(self) -> None:
        order = self.order
        order.folder.mkdir(parents=True, exist_ok=True)
        context = self._make_context()
        manifest = new_manifest(order.plan)
        with accounting(manifest, order.folder, manifest):
            try:
                for planned, entry in zip(order.plan.steps, manifest.steps, strict=True):
                    self._play_until_done(context, planned, entry, manifest)
            except CampaignStoppedError:
                if self._wish is Happening.STOP and not self._cut_off and order.finish is not None:
                    order.finish(context, manifest)
                raise

    def _play_until_done(
        self, context: StepContext, planned: PlannedStep, entry: StepEntry, manifest: Manifest
    ) -> None:
        """Play a step, again from its beginning after each pause."""
        self._step = planned
        self.progress.step, self.progress.title = entry.index, planned.title
        for attempt in range(1, 1000):
            if self._wish is Happening.PAUSE:
                self._pause(context)
            try:
                entry.files.clear()
                self._play_once(context, planned, entry, manifest)
            except CampaignStoppedError:
                if self._wish is not Happening.PAUSE or self._cut_off:
                    self._keep(entry, planned)
                    raise
                self._keep_aside(entry, planned, attempt)
                continue
            except BaseException:
                self._keep(entry, planned)
                raise
            self._keep(entry, planned)
            return

    def _play_once(
        self, context: StepContext, planned: PlannedStep, entry: StepEntry, manifest: Manifest
    ) -> None:
        self._book.step_changed(_running(entry))
        try:
            play_step(context, planned, entry, manifest)
        finally:
            self._book.step_changed(entry)

    def _pause(self, context: StepContext) -> None:
        """Wait until somebody resumes or ends the job; the drive is at rest, the lease is kept."""
        self._resumed.clear()
        if self._wish is Happening.PAUSE and not self._cut_off:
            with contextlib.suppress(
                ConflictError
            ):  # asked to stop in this very moment: `ask` is about to tell
                self._book.happened(Happening.HALTED, "")
            self._resumed.wait()
        if self._cut_off or self._wish in (Happening.STOP, Happening.ABORT):
            raise CampaignStoppedError("stopped while paused")
        self._stop = context.stop = threading.Event()
        if self._cut_off:
            self._stop.set()

    def _keep(self, entry: StepEntry, planned: PlannedStep) -> None:
        for name in entry.files:
            if isinstance(planned.step, RecordStep):
                self._book.recorded(entry, self.order.folder / name)

    def _keep_aside(self, entry: StepEntry, planned: PlannedStep, attempt: int) -> None:
        """Rename the cut-off recording of a paused step, which is then recorded anew under its own name."""
        if not isinstance(planned.step, RecordStep):
            return
        folder, name = self.order.folder / RECORDS, planned.step.name
        for suffix in (".parquet", JOURNAL_SUFFIX + ARCHIVE_SUFFIX):
            part = folder / f"{name}{suffix}"
            if part.exists():
                part = part.rename(folder / f"{name}.paused{attempt}{suffix}")
                if suffix == ".parquet":
                    self._book.recorded(entry, part)

    def _make_context(self) -> StepContext:
        order = self.order
        return StepContext(
            plan=order.plan,
            folder=order.folder,
            listener=KeepingListener(self.progress),
            stop=self._stop,
            driver=order.rig.worker.driver,
            on_rig=self._on_rig,
            watch=JobWatch(order.rig, self.progress, order.watch),
        )

    def _on_rig(self, title: str, work: Callable[[DriverRig], T], stop: threading.Event) -> T:
        if self._lease is None:
            raise ConflictError("the lease is not held", "start the job first")
        job = RigJob(title=f"{self.order.title}: {title}", run=work, stop=stop)
        return self.order.rig.perform(job, self._lease.id).result()

    def _judge(self, error: BaseException) -> tuple[Happening, str]:
        """Return what an error says of the job, and the reason in words."""
        if not self._cut_off and self._lease is not None and (lost := self._lease.why_lost()) is not None:
            self._cut_off = lost
        if self._cut_off:
            return Happening.CUT_OFF, self._cut_off
        if isinstance(error, CampaignStoppedError) and self._wish in (Happening.STOP, Happening.ABORT):
            return (
                Happening.RESTED,
                "stopped as asked" if self._wish is Happening.STOP else "aborted as asked",
            )
        if isinstance(error, ConflictError):
            return Happening.REFUSED, str(error)
        happening = _HAPPENING_OF.get(how_it_ended(error), Happening.FAILED)
        if happening is Happening.FAILED:
            _LOG.warning("%s failed", self.order.title, exc_info=error)
        return happening, " ".join(str(error).split()) or type(error).__name__


def _running(entry: StepEntry) -> StepEntry:
    entry.ended, entry.message = Ended.RUNNING, ""
    return entry
