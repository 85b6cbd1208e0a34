"""What the service does before it answers: nothing that was running still runs, and nothing received is lost.

Rows left in a running state by a process that died become `interrupted`, with the reason; a campaign that was cut
off is never begun again by itself. Journals left open become recordings. No rig is armed: rigs are opened anew, and
the controller's own lease has stopped its drive long before.
"""

from dataclasses import dataclass
from pathlib import Path

import sqlalchemy as sa

from daq.recording.journal import JOURNAL_SUFFIX
from daq.recording.recovery import RecoveryOutcome, recover_journals
from server.services.recordings.register import register_recording as register_recording
from server.services.run_folder import RECORDS
from server.storage.database import Database
from server.storage.states import UNDER_WAY, JobState
from server.storage.tables import (
    CampaignItemRow,
    CampaignRow,
    DiscrepancyRow,
    LeaseRow,
    SessionRow,
)
from server.storage.types import utc_now

REASON = "the service ended while this was under way; nothing was begun again by itself"
_JOBS: tuple[type[SessionRow | CampaignRow | CampaignItemRow | DiscrepancyRow], ...] = (
    SessionRow,
    CampaignRow,
    CampaignItemRow,
    DiscrepancyRow,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class StartReport:
    """What a start found.

    Attributes:
        interrupted: rows that were under way.
        recovered: recordings made of journals that were left open.
        notes: one sentence for each journal.
    """

    interrupted: int
    recovered: int
    notes: tuple[str, ...]


def recover(database: Database, data_dir: Path) -> StartReport:
    """Put database and data folder in order after a process that may have been killed."""
    folders = _folders_under_way(database)
    interrupted = _interrupt(database)
    notes, recovered = [], 0
    for folder in sorted({path.parent for path in data_dir.rglob(f"*{JOURNAL_SUFFIX}")}):
        for report in recover_journals(folder):
            notes.append(report.detail)
            if report.outcome is RecoveryOutcome.RECOVERED and report.recording is not None:
                recovered += 1
                _register_of_job(database, data_dir, report.recording)
    for listed in folders:  # finished in the very moment of the end, and not listed yet
        for path in sorted((data_dir / listed).rglob(f"{RECORDS}/*.parquet")):
            _register_of_job(database, data_dir, path)
    return StartReport(interrupted=interrupted, recovered=recovered, notes=tuple(notes))


def _register_of_job(database: Database, data_dir: Path, path: Path) -> None:
    """List a recording with the session or campaign that its folder belongs to."""
    kind, job_id, *_ = (*path.resolve().relative_to(data_dir.resolve()).parts, "")
    session_id, campaign_id = (job_id if kind == each else None for each in ("sessions", "campaigns"))
    recording_id = register_recording(
        database, data_dir, path, origin="recovered", session_id=session_id, campaign_id=campaign_id
    )
    if session_id is not None and path.stem == "train":
        with database.write() as session:
            session.execute(
                sa.update(SessionRow).where(SessionRow.id == session_id).values(recording_id=recording_id)
            )


def _folders_under_way(database: Database) -> list[str]:
    """Return the folders of the sessions and campaigns that were under way."""
    states = [state.value for state in UNDER_WAY]
    with database.read() as session:
        found = [
            session.scalars(sa.select(table.folder).where(table.state.in_(states))).all()
            for table in (SessionRow, CampaignRow)
        ]
    return [folder for folders in found for folder in folders if folder]


def _interrupt(database: Database) -> int:
    count, now = 0, utc_now()
    with database.write() as session:
        for table in _JOBS:
            changes = {"state": JobState.INTERRUPTED.value, "reason": REASON, "ended_at": now}
            stale = sa.update(table).where(table.state.in_([state.value for state in UNDER_WAY]))
            count += len(session.execute(stale.values(**changes).returning(table.id)).all())
        cut_off = sa.select(CampaignRow.id).where(CampaignRow.state == JobState.INTERRUPTED.value)
        waiting = sa.update(CampaignItemRow).where(
            CampaignItemRow.campaign_id.in_(cut_off), CampaignItemRow.state == JobState.QUEUED.value
        )
        session.execute(waiting.values(state=JobState.CANCELLED.value, reason="not begun"))
        session.execute(
            sa.update(LeaseRow).where(LeaseRow.ended_at.is_(None)).values(ended_at=now, ended_by="restart")
        )
    return count
