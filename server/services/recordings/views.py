"""Recordings as everybody may see them."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any

from server.services.errors import NotFoundError
from server.storage.tables import RecordingRow

_REMEDY = "GET /api/v1/recordings lists those that there are"


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingView:
    """One recording as it is listed.

    Attributes:
        origin: `session`, `campaign`, `upload` or `recovered`.
        columns: unit of each column.
        unreadable: why its file cannot be read, empty when it can.
        details: what else its metadata tell: excitation, how it ended, source, software.
        purge_at: when its files go, for one that is deleted.
        purged: its files are gone.
    """

    id: str
    name: str
    origin: str
    rig_id: str | None
    session_id: str | None
    campaign_id: str | None
    samples: int
    samples_lost: int
    duration_s: float
    sample_time_s: float | None
    size_octets: int
    columns: dict[str, str]
    unreadable: str
    details: dict[str, Any]  # JSON values
    created_by: str
    created_at: datetime
    deleted_at: datetime | None
    purge_at: datetime | None
    purged: bool


def find_row(row: RecordingRow | None, recording_id: str) -> RecordingRow:
    """Return the row.

    Raises:
        NotFoundError: there is none of this id.
    """
    if row is None:
        raise NotFoundError("recording", recording_id, _REMEDY)
    return row


def view_of(row: RecordingRow) -> RecordingView:
    """Return what is told of a recording."""
    details = dict(row.details)
    return RecordingView(
        id=row.id,
        name=row.name,
        origin=row.origin,
        rig_id=row.rig_id,
        session_id=row.session_id,
        campaign_id=row.campaign_id,
        samples=row.samples,
        samples_lost=row.samples_lost,
        duration_s=row.duration_s,
        sample_time_s=details.pop("sample_time_s", None),
        size_octets=row.size_octets,
        columns=details.pop("columns", {}),
        unreadable=details.pop("unreadable", ""),
        purged=details.pop("purged", False),
        details=details,
        created_by=row.created_by,
        created_at=row.created_at,
        deleted_at=row.deleted_at,
        purge_at=row.purge_at,
    )
