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
    interrupted = _interrupt(database)
    notes, recovered = [], 0
    for folder in sorted({path.parent for path in data_dir.rglob(f"*{JOURNAL_SUFFIX}")}):
        for report in recover_journals(folder):
            notes.append(report.detail)
            if report.outcome is RecoveryOutcome.RECOVERED and report.recording is not None:
                recovered += 1
                register_recording(database, data_dir, report.recording, origin="recovered")
    return StartReport(interrupted=interrupted, recovered=recovered, notes=tuple(notes))


def _interrupt(database: Database) -> int:
    count, now = 0, utc_now()
    with database.write() as session:
        for table in _JOBS:
            changes = {"state": JobState.INTERRUPTED.value, "reason": REASON, "ended_at": now}
            stale = sa.update(table).where(table.state.in_([state.value for state in UNDER_WAY]))
            count += len(session.execute(stale.values(**changes).returning(table.id)).all())
        session.execute(
            sa.update(LeaseRow).where(LeaseRow.ended_at.is_(None)).values(ended_at=now, ended_by="restart")
        )
    return count
