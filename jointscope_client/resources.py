"""What the service has, by kind: rigs, recordings, models, discrepancies, sessions, campaigns."""

import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, Protocol, TypeVar

from jointscope_client import calls, records
from jointscope_client.calls import get, many, one, path_of, post
from jointscope_client.errors import NotDoneError
from jointscope_client.jobs import ENDED, check_done
from jointscope_client.samples import Samples

T = TypeVar("T")


class Performer(Protocol):
    """What sends calls: `Client`."""

    def perform(self, call: calls.Call[T]) -> T:
        """Send one call."""
        ...

    def pages(self, call: calls.Call[calls.Page[T]]) -> Iterator[T]:
        """Give all items of a list."""
        ...

    def download(self, call: calls.Call[None], target: Path) -> Path:
        """Write an answer's body to a file."""
        ...


class Rigs:
    """Rigs: connection, state, parameters, stop. What moves one is done through its lease."""

    def __init__(self, client: Performer) -> None:
        self._client = client

    def all(self) -> list[records.Rig]:
        """Return all rigs."""
        return self._client.perform(get(path_of("rigs"), many(records.read_rig)))

    def get(self, rig_id: str) -> records.Rig:
        """Return a rig's state."""
        return self._client.perform(get(path_of("rigs", rig_id), one(records.read_rig)))

    def connect(self, rig_id: str) -> records.Rig:
        """Open the rig's port; its drive stays off."""
        return self._client.perform(post(path_of("rigs", rig_id, "connect"), one(records.read_rig)))

    def disconnect(self, rig_id: str) -> records.Rig:
        """Give the rig's port back."""
        return self._client.perform(post(path_of("rigs", rig_id, "disconnect"), one(records.read_rig)))

    def estop(self, rig_id: str) -> records.Rig:
        """Switch the drive off at once; no lease is needed. Beside a wired emergency stop, never instead of one."""
        return self._client.perform(post(path_of("rigs", rig_id, "estop"), one(records.read_rig)))

    def parameters(self, rig_id: str) -> list[records.Parameter]:
        """Read all parameters from the controller."""
        return self._client.perform(get(path_of("rigs", rig_id, "parameters"), many(records.read_parameter)))

    def link(self, rig_id: str) -> dict[str, Any]:  # JSON values
        """Tell how the link is doing."""
        found: dict[str, Any] = self._client.perform(get(path_of("rigs", rig_id, "link"), calls.as_json))
        return found


class Recordings:
    """Recordings: list, samples, upload, download, deletion."""

    def __init__(self, client: Performer) -> None:
        self._client = client

    def all(self, **filters: Any) -> Iterator[records.RecordingInfo]:  # text, numbers, times
        """Give recordings, newest first.

        Filters: rig, session, campaign, origin, since, until, column, text, deleted; `limit` is the size of a page.
        """
        return self._client.pages(calls.listing("recordings", records.read_recording, filters))

    def get(self, recording_id: str) -> records.RecordingInfo:
        """Return what is known of a recording."""
        return self._client.perform(get(path_of("recordings", recording_id), one(records.read_recording)))

    def samples(
        self,
        recording_id: str,
        columns: Sequence[str] = (),
        *,
        span_s: tuple[float | None, float | None] = (None, None),
        every: int = 1,
        points: int | None = None,
    ) -> Samples:
        """Read samples as numpy arrays, all digits kept.

        Args:
            recording_id: the recording.
            columns: only these; none takes all.
            span_s: from the first time on, up to the second, which is left out; None is open.
            every: every so manieth sample, unfiltered.
            points: instead, minimum and maximum over so many pieces, to draw.
        """
        params = {"column": list(columns), "start_s": span_s[0], "stop_s": span_s[1]}
        params |= {"every": every, "points": points}
        return self._client.perform(calls.samples(recording_id, params))

    def upload(
        self,
        path: Path,
        *,
        name: str | None = None,
        mappings: Sequence[str] = (),
        leave_out: Sequence[str] = (),
    ) -> records.RecordingInfo:
        """Upload a measured file: CSV, CSV.gz, Parquet, MAT, HDF5.

        Args:
            path: the file.
            name: of the recording; None takes the file's.
            mappings: `NEW=OLD`, `NEW=OLD*FACTOR` or `NEW=OLD[UNIT]`.
            leave_out: columns not to take.
        """
        return self._client.perform(calls.upload(path, name, mappings, leave_out))

    def download(self, recording_id: str, target: Path, file_format: str = "parquet") -> Path:
        """Download a recording as parquet, csv, mat, hdf5, mdf4, mcap, or `stored`, as the service keeps it."""
        path = path_of("recordings", recording_id, "file")
        return self._client.download(get(path, calls.nothing, {"format": file_format}), target)

    def delete(self, recording_id: str) -> records.RecordingInfo:
        """Delete a recording; it can be taken back for some weeks."""
        path = path_of("recordings", recording_id)
        return self._client.perform(calls.Call(method="DELETE", path=path, read=one(records.read_recording)))

    def undelete(self, recording_id: str) -> records.RecordingInfo:
        """Take a deletion back."""
        path = path_of("recordings", recording_id, "undelete")
        return self._client.perform(post(path, one(records.read_recording)))


class Models:
    """Joint models and their versions."""

    def __init__(self, client: Performer) -> None:
        self._client = client

    def all(self, **filters: Any) -> Iterator[records.Model]:  # text and numbers
        """Give model versions, newest first. Filters: name, source."""
        return self._client.pages(calls.listing("models", records.read_model, filters))

    def get(self, model_id: str) -> records.Model:
        """Return one version."""
        return self._client.perform(get(path_of("models", model_id), one(records.read_model)))

    def add(self, text: str, *, note: str = "", parent: str | None = None) -> records.Model:
        """Add a version from a model file's text."""
        return self._client.perform(calls.add_model(text, note, parent))

    def file(self, model_id: str) -> str:
        """Return one version as a model file."""
        return self._client.perform(get(path_of("models", model_id, "file"), calls.as_text))


class Discrepancies:
    """Discrepancy analyses: what does a model lack?"""

    def __init__(self, client: Performer) -> None:
        self._client = client

    def all(self, **filters: Any) -> Iterator[records.Analysis]:  # text and numbers
        """Give analyses, newest first. Filter: model, the one that they made."""
        return self._client.pages(calls.listing("discrepancies", records.read_analysis, filters))

    def get(self, analysis_id: str) -> records.Analysis:
        """Tell how far an analysis is, or what it found."""
        return self._client.perform(get(path_of("discrepancies", analysis_id), one(records.read_analysis)))

    def start(self, model: str, train: Sequence[str], test: Sequence[str]) -> records.Analysis:
        """Queue an analysis of a model version by recordings, all named by their ids."""
        body = {"model": model, "train": list(train), "test": list(test)}
        return self._client.perform(post(path_of("discrepancies"), one(records.read_analysis), body))

    def cancel(self, analysis_id: str) -> records.Analysis:
        """End an analysis."""
        return self._client.perform(
            post(path_of("discrepancies", analysis_id, "cancel"), one(records.read_analysis))
        )

    def gap(self, analysis_id: str) -> dict[str, Any]:  # JSON values
        """Return the whole answer, `gap.json`."""
        found: dict[str, Any] = self._client.perform(
            get(path_of("discrepancies", analysis_id, "gap"), calls.as_json)
        )
        return found

    def report(self, analysis_id: str) -> str:
        """Return the report, one page of HTML."""
        return self._client.perform(get(path_of("discrepancies", analysis_id, "report"), calls.as_text))

    def wait(
        self,
        analysis_id: str,
        on_progress: Callable[[records.Analysis], None] = lambda view: None,
        *,
        timeout_s: float = 3600.0,
        every_s: float = 0.5,
    ) -> records.Analysis:
        """Wait until an analysis is done.

        Raises:
            NotDoneError: it ended otherwise, or not in time.
        """
        return wait_until_done(lambda: self.get(analysis_id), on_progress, timeout_s, every_s)


class Jobs:
    """Sessions or campaigns: both are begun, paused, ended and watched alike.

    Args:
        client: what sends calls.
        kind: `sessions` or `campaigns`.
    """

    def __init__(self, client: Performer, kind: str) -> None:
        self._client = client
        self._kind = kind

    def all(self, **filters: Any) -> Iterator[records.Job]:  # text, numbers, times
        """Give them, newest first. Filters: rig, state."""
        return self._client.pages(calls.listing(self._kind, records.read_job, filters))

    def get(self, job_id: str) -> records.Job:
        """Tell the state of one."""
        return self._client.perform(get(path_of(self._kind, job_id), one(records.read_job)))

    def command(self, job_id: str, command: str) -> records.Job:
        """Give a command: start, pause, resume, stop or abort."""
        return self._client.perform(post(path_of(self._kind, job_id, command), one(records.read_job)))

    def follow(
        self, job_id: str, *, timeout_s: float = 7200.0, every_s: float = 0.5
    ) -> Iterator[records.Job]:
        """Give each change until the end.

        Raises:
            NotDoneError: not in time.
        """
        deadline_s, before = time.monotonic() + timeout_s, None
        while True:
            job = self.get(job_id)
            if job.raw != before:
                before = job.raw
                yield job
            if job.state in ENDED:
                return
            if time.monotonic() > deadline_s:
                raise NotDoneError(f"still {job.state} after {timeout_s:g} s", job.state)
            time.sleep(every_s)

    def wait(
        self,
        job_id: str,
        on_progress: Callable[[records.Job], None] = lambda job: None,
        *,
        timeout_s: float = 7200.0,
        every_s: float = 0.5,
    ) -> records.Job:
        """Wait until one is done.

        Raises:
            NotDoneError: it ended otherwise, or not in time.
        """
        return wait_until_done(lambda: self.get(job_id), on_progress, timeout_s, every_s)


class Sessions:
    """Identification sessions: `jobs` begins, pauses, ends and watches them."""

    def __init__(self, client: Performer) -> None:
        self._client = client
        self.jobs = Jobs(client, "sessions")

    def create(self, **spec: Any) -> records.Job:  # JSON values
        """Create a session: rig, excitation, duration_s, estimators, ... as the API's document says."""
        return self._client.perform(post(path_of("sessions"), one(records.read_job), spec))


class Campaigns:
    """Campaigns: `jobs` pauses, ends and watches them."""

    def __init__(self, client: Performer) -> None:
        self._client = client
        self.jobs = Jobs(client, "campaigns")

    def submit(self, text: str, *, rig: str) -> records.Job:
        """Queue a campaign from a campaign file's text."""
        return self._client.perform(calls.submit_campaign(text, {"rig": rig}, one(records.read_job)))

    def dry_run(self, text: str, *, rig: str) -> dict[str, Any]:  # JSON values
        """Check every step against the rig's limits and predict travel and duration; nothing moves."""
        params = {"rig": rig, "dry_run": True}
        found: dict[str, Any] = self._client.perform(calls.submit_campaign(text, params, calls.as_json))
        return found


V = TypeVar("V", records.Analysis, records.Job)


def wait_until_done(look: Callable[[], V], tell: Callable[[V], None], timeout_s: float, every_s: float) -> V:
    """Look again and again until the end; `tell` is called with each look.

    Raises:
        NotDoneError: it ended otherwise than done, or not in time.
    """
    deadline_s = time.monotonic() + timeout_s
    while True:
        view = look()
        tell(view)
        if check_done(view.state, view.reason, time.monotonic() > deadline_s):
            return view
        time.sleep(every_s)
