"""Which jobs run now, at most one on each rig; ends them in order when the service ends."""

import threading

from server.services.errors import BusyError, ClosingError
from server.services.jobs.order import JobBook, JobOrder
from server.services.jobs.run import JobRun

_END_S = 30.0
CLOSING = "the service was ended while this was under way; nothing is begun again by itself"


class JobBoard:
    """All running jobs."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._runs: dict[str, JobRun] = {}
        self._closing = False

    def launch(self, order: JobOrder, book: JobBook) -> JobRun:
        """Start a job.

        Raises:
            BusyError: another job runs on that rig.
            ClosingError: the service ends.
        """
        with self._lock:
            if self._closing:
                raise ClosingError("the service is shutting down", "start it again")
            self._forget_ended()
            for run in self._runs.values():
                if run.order.rig.id == order.rig.id:
                    raise BusyError(
                        f"rig {order.rig.id} is busy with {run.order.title}", "wait for its end, or stop it"
                    )
            run = self._runs[order.id] = JobRun(order, book)
            run.start()
            return run

    def find(self, job_id: str) -> JobRun | None:
        """Return a running job."""
        with self._lock:
            return self._runs.get(job_id)

    def is_free(self, rig_id: str) -> bool:
        """Tell whether no job runs on a rig."""
        with self._lock:
            self._forget_ended()
            return all(run.order.rig.id != rig_id for run in self._runs.values())

    def close(self) -> None:
        """End all jobs: their drives come to rest, and they are marked as interrupted."""
        with self._lock:
            self._closing = True
            runs = list(self._runs.values())
        for run in runs:
            run.cut_off(CLOSING)
        for run in runs:
            run.join(_END_S)

    def _forget_ended(self) -> None:
        self._runs = {job_id: run for job_id, run in self._runs.items() if run.alive}
