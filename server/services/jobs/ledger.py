"""Where jobs stand, in the database: the only place that changes the state of a session or a campaign."""

from collections.abc import Callable
from dataclasses import dataclass

import sqlalchemy as sa
from sqlalchemy.orm import Session

from server.services.errors import ConflictError, InvalidValueError, NotFoundError
from server.services.jobs.machine import ENDED, Happening, allowed, follow
from server.storage.database import Database
from server.storage.states import JobState
from server.storage.tables import CampaignRow, SessionRow
from server.storage.types import utc_now

JobRow = SessionRow | CampaignRow
Also = Callable[[Session, JobState], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class JobFilter:
    """Which jobs to list; None leaves a filter out."""

    rig_id: str | None = None
    state: JobState | None = None
    name: str | None = None
    before: str | None = None
    limit: int = 50


class JobLedger:
    """States of all jobs of one kind.

    Args:
        database: where they are kept.
        table: of this kind of job.
        kind: `session` or `campaign`, for messages.
    """

    def __init__(self, database: Database, table: type[SessionRow] | type[CampaignRow], kind: str) -> None:
        self._database = database
        self._table = table
        self.kind = kind

    def happen(
        self, job_id: str, happening: Happening, reason: str = "", also: Also | None = None
    ) -> tuple[JobState, JobState]:
        """Take note of what happened, and return the states before and after.

        Args:
            job_id: of the job.
            happening: what happened.
            reason: why; empty leaves the one that is there.
            also: changes what else belongs to the new state, in the same transaction.

        Raises:
            NotFoundError: no such job.
            ConflictError: it cannot happen in the present state.
        """
        with self._database.write() as session:
            row = self._find(session, job_id)
            before = JobState(row.state)
            after = follow(before, happening)
            if after is None:
                raise self._refused(row, before, happening)
            row.state = after.value
            _keep_times(row, after, reason)
            if also is not None:
                also(session, after)
            return before, after

    def state(self, job_id: str) -> JobState:
        """Return where a job stands.

        Raises:
            NotFoundError: no such job.
        """
        return JobState(self.row(job_id).state)

    def row(self, job_id: str) -> JobRow:
        """Return a job's row, to be read only.

        Raises:
            NotFoundError: no such job.
        """
        with self._database.read() as session:
            return self._find(session, job_id)

    def page(self, wanted: JobFilter) -> list[JobRow]:
        """Return jobs, newest first; `before` continues after the last one of a page.

        Raises:
            InvalidValueError: `before` names no job.
        """
        table = self._table
        query = sa.select(table).order_by(table.created_at.desc(), table.id.desc()).limit(wanted.limit)
        for column, value in ((table.rig_id, wanted.rig_id), (table.name, wanted.name)):
            if value is not None:
                query = query.where(column == value)
        if wanted.state is not None:
            query = query.where(table.state == wanted.state.value)
        with self._database.read() as session:
            if wanted.before is not None:
                last = self._last_of_page(session, wanted.before)
                query = query.where(sa.tuple_(table.created_at, table.id) < (last.created_at, last.id))
            return list(session.scalars(query))

    def note(self, job_id: str, **columns: object) -> None:
        """Write columns other than the state."""
        with self._database.write() as session:
            session.execute(sa.update(self._table).where(self._table.id == job_id).values(**columns))

    def _find(self, session: Session, job_id: str) -> JobRow:
        row = session.scalar(sa.select(self._table).where(self._table.id == job_id))
        if not isinstance(row, SessionRow | CampaignRow):
            raise self._unknown(job_id)
        return row

    def _last_of_page(self, session: Session, job_id: str) -> JobRow:
        try:
            return self._find(session, job_id)
        except NotFoundError as error:
            raise InvalidValueError(
                f"there is no {self.kind} {job_id!r} to continue after",
                field="before",
                value=job_id,
                remedy="give the `next_before` of the page before",
            ) from error

    def _unknown(self, job_id: str) -> NotFoundError:
        return NotFoundError(self.kind, job_id, f"list them by GET /api/v1/{self.kind}s")

    def _refused(self, row: JobRow, state: JobState, happening: Happening) -> ConflictError:
        able = [each for each in allowed(state) if self.kind == "campaign" or each is not Happening.REQUEUE]
        remedy = f"possible now: {', '.join(able)}" if able else f"create a new {self.kind}"
        return ConflictError(f'{self.kind} "{row.name}" is {state}: {happening} is not possible', remedy)


def _keep_times(row: JobRow, state: JobState, reason: str) -> None:
    if state is JobState.STARTING:
        row.started_at = utc_now()
    if state is JobState.QUEUED:
        row.started_at = row.ended_at = None
        row.reason = ""
    if reason:
        row.reason = reason
    if state in ENDED:
        row.ended_at = utc_now()
