"""Where analyses stand, in the database, and told as events: the only place that changes the state of one."""

import threading
import time
import uuid
from typing import Any

import sqlalchemy as sa

from server.services.analyses.records import AnalysisRequest, AnalysisView, Json, find_row, view_of
from server.services.errors import ConflictError
from server.services.events import EventLog, ServiceEvent
from server.services.figures import Durations
from server.storage.database import Database
from server.storage.states import JobState
from server.storage.tables import DiscrepancyRow
from server.storage.types import utc_now

FOLDER = "discrepancies"
ENDED = frozenset({JobState.DONE, JobState.FAILED, JobState.CANCELLED, JobState.INTERRUPTED})
NO_RIG = ""  # an analysis belongs to none
_TELL_EVERY_S = 2.0  # progress; every change is in the analysis itself


class AnalysisLedger:
    """States of all analyses.

    Args:
        database: where they are kept.
        events: told of each change.
    """

    def __init__(self, database: Database, events: EventLog) -> None:
        self._database = database
        self._events = events
        self._lock = threading.Lock()
        self._told_s: dict[str, float] = {}
        self.took = Durations()

    def add(self, request: AnalysisRequest, created_by: str) -> AnalysisView:
        """Write down a new one, which waits."""
        row = DiscrepancyRow(
            id=str(uuid.uuid4()),
            state=JobState.QUEUED.value,
            request={"model": request.model, "train": request.train, "test": request.test},
            created_by=created_by,
        )
        row.folder = f"{FOLDER}/{row.id}"
        with self._database.write() as session:
            session.add(row)
            session.flush()
            view = view_of(row)
        self._tell(view.id, JobState.QUEUED, f"of {created_by}")
        return view

    def row(self, analysis_id: str) -> DiscrepancyRow:
        """Return a row, to be read only.

        Raises:
            NotFoundError: there is none of this id.
        """
        with self._database.read() as session:
            return find_row(session.get(DiscrepancyRow, analysis_id), analysis_id)

    def page(
        self, *, state: JobState | None, model_id: str | None, offset: int, limit: int
    ) -> list[AnalysisView]:
        """Return analyses, newest first; `model_id` is the one that they made."""
        query = sa.select(DiscrepancyRow).order_by(DiscrepancyRow.created_at.desc(), DiscrepancyRow.id)
        if state is not None:
            query = query.where(DiscrepancyRow.state == state.value)
        if model_id is not None:
            query = query.where(DiscrepancyRow.model_id == model_id)
        with self._database.read() as session:
            return [view_of(row) for row in session.scalars(query.offset(offset).limit(limit))]

    def waiting(self) -> list[str]:
        """Return the ids of those that wait, oldest first."""
        query = sa.select(DiscrepancyRow.id).where(DiscrepancyRow.state == JobState.QUEUED.value)
        with self._database.read() as session:
            return list(session.scalars(query.order_by(DiscrepancyRow.created_at)))

    def count(self, state: JobState) -> int:
        """Return how many are in a state."""
        query = sa.select(sa.func.count()).select_from(DiscrepancyRow)
        with self._database.read() as session:
            return session.scalar(query.where(DiscrepancyRow.state == state.value)) or 0

    def cancel(self, analysis_id: str) -> AnalysisView:
        """Mark one that has not ended as cancelled.

        Raises:
            NotFoundError: there is none of this id.
            ConflictError: it has ended.
        """
        with self._database.write() as session:
            row = find_row(session.get(DiscrepancyRow, analysis_id), analysis_id)
            if JobState(row.state) in ENDED:
                raise ConflictError(f"this analysis has ended: {row.state}", "start another one")
            row.state, row.ended_at = JobState.CANCELLED.value, utc_now()
            row.reason = "cancelled"
            view = view_of(row)
        self._tell(analysis_id, JobState.CANCELLED, "")
        return view

    def begin(self, analysis_id: str) -> bool:
        """Mark one that still waits as running; tells whether it did."""
        with self._database.write() as session:
            row = session.get(DiscrepancyRow, analysis_id)
            if row is None or row.state != JobState.QUEUED.value:
                return False
            row.state, row.started_at = JobState.RUNNING.value, utc_now()
        self._tell(analysis_id, JobState.RUNNING, "")
        return True

    def progress(self, analysis_id: str, progress: Json) -> None:
        """Keep how far one is; told as an event every two seconds at most."""
        if not self._change(analysis_id, progress=progress):
            return
        now_s = time.monotonic()
        with self._lock:
            if now_s < self._told_s.get(analysis_id, 0.0) + _TELL_EVERY_S:
                return
            self._told_s[analysis_id] = now_s
        told = {"id": analysis_id, **progress}
        self._publish("analysis.progress", f"analysis {analysis_id[:8]}: {progress['text']}", told)

    def end(self, analysis_id: str, state: JobState, reason: str, **more: Any) -> None:  # JSON values
        """Mark one that runs as ended; one that was cancelled meanwhile stays as it is."""
        with self._lock:
            self._told_s.pop(analysis_id, None)
        ended_at = utc_now()
        if self._change(analysis_id, state=state.value, reason=reason, ended_at=ended_at, **more):
            self._tell(analysis_id, state, reason, **{key: more[key] for key in ("model_id",) if key in more})
        row = self.row(analysis_id)
        if row.started_at is not None:
            self.took.observe((ended_at - row.started_at).total_seconds())

    def _change(self, analysis_id: str, **values: Any) -> bool:  # columns
        still = sa.and_(DiscrepancyRow.id == analysis_id, DiscrepancyRow.state == JobState.RUNNING.value)
        changed = sa.update(DiscrepancyRow).where(still).values(**values).returning(DiscrepancyRow.id)
        with self._database.write() as session:
            return session.scalar(changed) is not None

    def _tell(self, analysis_id: str, state: JobState, because: str, **more: Any) -> None:  # JSON values
        words = f"analysis {analysis_id[:8]} is {state}" + (f": {because}" if because else "")
        self._publish(f"analysis.{state}", words, {"id": analysis_id, "state": state.value, **more})

    def _publish(self, kind: str, text: str, data: Json) -> None:
        self._events.publish(ServiceEvent(rig_id=NO_RIG, kind=kind, text=text, data=data))
