"""Discrepancy analyses as background jobs: queued, run one after the other, cancelled, kept across restarts.

One at a time, since each uses all cores it may. A job that was under way when the service ended is `interrupted` and
never begun again by itself; those that still waited are taken up.
"""

import logging
import queue
import re
import shutil
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from server.services.analyses.answer import INPUT_NAME, keep_answer
from server.services.analyses.ledger import FOLDER, AnalysisLedger
from server.services.analyses.process import AnalysisProcess, AnalysisTask
from server.services.analyses.records import AnalysisRequest, AnalysisView, Json, view_of
from server.services.errors import ConflictError, InvalidValueError, NotFoundError
from server.services.models import ModelStore
from server.services.recordings.catalogue import RecordingCatalogue
from server.storage.states import JobState

_LOG = logging.getLogger(__name__)
_FITS = re.compile(r"(\d+) fits")


class AnalysisJobs:
    """Takes, runs and keeps analyses.

    Args:
        ledger: where they are kept, and told.
        data_dir: where their files are.
        recordings: finds the recordings.
        models: finds the models, and takes the extended ones.
        jobs: processes that one analysis may use.
    """

    def __init__(
        self,
        ledger: AnalysisLedger,
        data_dir: Path,
        recordings: RecordingCatalogue,
        models: ModelStore,
        jobs: int,
    ) -> None:
        self.ledger = ledger
        self._data_dir = data_dir
        self._recordings = recordings
        self._models = models
        self._jobs = jobs
        self._waiting: queue.Queue[str | None] = queue.Queue()
        self._thread = threading.Thread(target=self._run, name="jointscope-analyses", daemon=True)
        self._lock = threading.Lock()
        self._running: tuple[str, AnalysisProcess] | None = None
        self._closing = False

    def start(self) -> None:
        """Begin to work, first on what still waited when the service ended."""
        for each in self.ledger.waiting():
            self._waiting.put(each)
        self._thread.start()

    def close(self) -> None:
        """End what runs; it becomes `interrupted`, what waits stays queued."""
        with self._lock:
            self._closing = True
            running = self._running
        if running is not None:
            running[1].end()
        self._waiting.put(None)
        if self._thread.is_alive():
            self._thread.join()

    @property
    def running(self) -> int:
        """How many run."""
        return 0 if self._running is None else 1

    @property
    def queued(self) -> int:
        """How many wait."""
        return self.ledger.count(JobState.QUEUED)

    def submit(self, request: AnalysisRequest, created_by: str) -> AnalysisView:
        """Queue an analysis.

        Raises:
            NotFoundError: no such model or recording.
            ConflictError: a recording is deleted.
            InvalidValueError: no recording to fit or to test, or one that stands twice.
        """
        self._check(request)
        view = self.ledger.add(request, created_by)
        self._waiting.put(view.id)
        return view

    def get(self, analysis_id: str) -> AnalysisView:
        """Return one analysis.

        Raises:
            NotFoundError: there is none of this id.
        """
        return view_of(self.ledger.row(analysis_id))

    def page(
        self, *, state: JobState | None = None, model_id: str | None = None, offset: int = 0, limit: int = 100
    ) -> list[AnalysisView]:
        """Return analyses, newest first; `model_id` is the one that they made."""
        return self.ledger.page(state=state, model_id=model_id, offset=offset, limit=limit)

    def cancel(self, analysis_id: str) -> AnalysisView:
        """End an analysis, whether it waits or runs.

        Raises:
            NotFoundError: there is none of this id.
            ConflictError: it has ended.
        """
        with self._lock:
            view, running = self.ledger.cancel(analysis_id), self._running
        if running is not None and running[0] == analysis_id:
            running[1].end()
        return view

    def file(self, analysis_id: str, name: str) -> Path:
        """Return a file of a finished analysis: `gap.json`, `report.html`, `model.yaml`.

        Raises:
            NotFoundError: there is no such analysis.
            ConflictError: it has not come to an answer.
        """
        row = self.ledger.row(analysis_id)
        path = self._data_dir / (row.folder or "") / name
        if row.state != JobState.DONE.value or not path.is_file():
            raise ConflictError(
                f"this analysis is {row.state} and has no answer",
                "wait until it is done, or start another one",
            )
        return path

    def _check(self, request: AnalysisRequest) -> None:
        self._models.get(request.model)
        everything = [*request.train, *request.test]
        for field, ids in (("train", request.train), ("test", request.test)):
            if not ids:
                raise InvalidValueError(
                    f"{field}: at least one recording is needed",
                    field=field,
                    value=None,
                    remedy="name one by its id",
                )
            doubled = [each for each in ids if everything.count(each) > 1]
            if doubled:
                raise InvalidValueError(
                    f"{field}: a recording stands twice", field=field, value=doubled[0], remedy="name it once"
                )
            self._recordings.relative_paths(ids)

    def _run(self) -> None:
        while (analysis_id := self._waiting.get()) is not None:
            try:
                self._work_on(analysis_id)
            except Exception as error:  # noqa: BLE001  # outermost loop: one analysis must not end the others
                _LOG.exception("analysis %s failed", analysis_id)
                self.ledger.end(analysis_id, JobState.FAILED, f"{type(error).__name__}: {error}")

    def _work_on(self, analysis_id: str) -> None:
        with self._lock:  # a cancellation comes before this, or finds the process
            if self._closing or not self.ledger.begin(analysis_id):
                return
            try:
                process = AnalysisProcess(self._prepare(analysis_id), self._data_dir)
            except (NotFoundError, ConflictError) as error:  # deleted while it waited
                self.ledger.end(analysis_id, JobState.FAILED, str(error))
                return
            self._running = analysis_id, process
        try:
            last = self._follow(analysis_id, process)
        finally:
            with self._lock:
                self._running = None
            process.close()
        self._conclude(analysis_id, last)

    def _prepare(self, analysis_id: str) -> AnalysisTask:
        request, out = self.get(analysis_id).request, f"{FOLDER}/{analysis_id}"
        folder = self._data_dir / out
        folder.mkdir(parents=True, exist_ok=True)
        (folder / INPUT_NAME).write_text(self._models.text(request.model), encoding="utf-8")
        return AnalysisTask(
            model=f"{out}/{INPUT_NAME}",
            train=self._recordings.relative_paths(request.train),
            test=self._recordings.relative_paths(request.test),
            out=out,
            jobs=self._jobs,
        )

    def _follow(self, analysis_id: str, process: AnalysisProcess) -> Json:
        """Write down what the process tells and return its last words."""
        begun_s, last = time.monotonic(), Json()
        progress: Json = {"text": "", "fits": 0, "elapsed_s": 0.0}
        for message in process.messages():
            last = message
            if "tell" in message:
                text = str(message["tell"]).strip()
                fits = _FITS.search(text)
                progress = {
                    "text": text,
                    "fits": int(fits[1]) if fits else progress["fits"],
                    "elapsed_s": round(time.monotonic() - begun_s, 1),
                }
                self.ledger.progress(analysis_id, progress)
        return last

    def _conclude(self, analysis_id: str, last: Mapping[str, Any]) -> None:
        if self._closing and "done" not in last:
            self.ledger.end(
                analysis_id, JobState.INTERRUPTED, "the service was ended while this was under way"
            )
        elif "error" in last:
            self.ledger.end(analysis_id, JobState.FAILED, str(last["error"]))
        elif "done" not in last:
            self.ledger.end(
                analysis_id, JobState.FAILED, "the analysis' process ended without a word: see its log"
            )
        else:
            self._keep(analysis_id)
        if self.get(analysis_id).state is JobState.CANCELLED:
            shutil.rmtree(self._data_dir / FOLDER / analysis_id, ignore_errors=True)

    def _keep(self, analysis_id: str) -> None:
        """Store the answer and make the extended model a version."""
        view, folder = self.get(analysis_id), self._data_dir / FOLDER / analysis_id
        if view.state is not JobState.RUNNING:
            return
        result, model_id = keep_answer(view, folder, self._models)
        self.ledger.end(analysis_id, JobState.DONE, "", result=result, model_id=model_id)
