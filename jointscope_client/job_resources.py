"""What runs in the service for a while: discrepancy analyses, sessions, campaigns."""

import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

from jointscope_client import calls, records
from jointscope_client.calls import get, one, path_of, post
from jointscope_client.ended import ENDED, check_done
from jointscope_client.errors import NotDoneError
from jointscope_client.resources import Performer

V = TypeVar("V", records.Analysis, records.Job)


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
