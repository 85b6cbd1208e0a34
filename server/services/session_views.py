"""Identification sessions as everybody may see them."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any

from server.services.jobs.books import shown_state
from server.services.jobs.machine import Happening, allowed
from server.services.jobs.order import JobProgress
from server.services.jobs.run import JobRun
from server.services.live.estimators import LiveEstimators
from server.storage.states import JobState
from server.storage.tables import SessionRow

Json = dict[str, Any]  # JSON values


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionView:
    """A session as everybody may see it; `live` and `progress` only while it runs."""

    id: str
    name: str
    rig_id: str
    state: JobState
    reason: str
    possible: tuple[Happening, ...]
    spec: Json
    figures: Json
    live: Json | None
    progress: JobProgress | None
    recording_id: str | None
    created_by: str
    created_at: datetime
    started_at: datetime | None
    ended_at: datetime | None


def session_view(row: SessionRow, run: JobRun | None, live: LiveEstimators | None) -> SessionView:
    """Return a session as it is shown.

    Args:
        row: what is stored of it.
        run: its job, None when it does not run.
        live: its estimators, None when it was not begun.
    """
    state = shown_state(row)
    running = run is not None and run.alive
    return SessionView(
        id=row.id,
        name=row.name,
        rig_id=row.rig_id,
        state=state,
        reason=row.reason,
        possible=tuple(each for each in allowed(state) if each is not Happening.REQUEUE),
        spec=row.spec,
        figures=row.figures,
        live=live.snapshot() if running and live is not None else row.figures.get("live"),
        progress=run.progress if running and run is not None else None,
        recording_id=row.recording_id,
        created_by=row.created_by,
        created_at=row.created_at,
        started_at=row.started_at,
        ended_at=row.ended_at,
    )
