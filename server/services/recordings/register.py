"""Lists a recording file in the database: whatever sessions, campaigns, uploads and recoveries have made."""

import uuid
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from daq.errors import RecordingError
from daq.recording.recording import Recording
from daq.recording.store import read_recording
from server.storage.database import Database
from server.storage.tables import RecordingRow

_TOLD = ("ended", "excitation", "operator", "started_utc", "time_base", "source", "software")


@dataclass(frozen=True, slots=True, kw_only=True)
class Listing:
    """What is known of a recording beyond its file; all of it optional.

    Attributes:
        name: for people; None takes the file's name.
        created_by: name of the token that made it.
        session_id: the session that made it.
        campaign_id: the campaign that made it.
    """

    name: str | None = None
    created_by: str = ""
    session_id: str | None = None
    campaign_id: str | None = None


def register_recording(  # noqa: PLR0913  # the two ids may be given by name, as sessions and campaigns do
    database: Database,
    data_dir: Path,
    path: Path,
    *,
    origin: str,
    session_id: str | None = None,
    campaign_id: str | None = None,
    listing: Listing | None = None,
) -> str:
    """List a recording file in the database, once, and return its id.

    Args:
        database: where it is listed.
        data_dir: paths are relative to it.
        path: Parquet file below the data folder.
        origin: `session`, `campaign`, `upload` or `recovered`.
        session_id: the session that made it.
        campaign_id: the campaign that made it.
        listing: what else is known of it.
    """
    known = listing or Listing(session_id=session_id, campaign_id=campaign_id)
    row = _make_row(path, str(path.resolve().relative_to(data_dir.resolve())), origin)
    row.name = (known.name or path.stem)[:200]
    row.created_by = known.created_by
    row.session_id, row.campaign_id = known.session_id, known.campaign_id
    with database.write() as session:
        listed = session.scalar(sa.select(RecordingRow.id).where(RecordingRow.path == row.path))
        if listed is not None:
            return listed
        session.add(row)
    return row.id


def describe_recording(recording: Recording) -> dict[str, Any]:  # JSON values
    """Return what the list and its filters need to know without opening the file again."""
    told = {key: recording.metadata[key] for key in _TOLD if key in recording.metadata}
    return {
        "columns": {name: recording.units[name] for name in recording.columns},
        "sample_time_s": recording.sample_time_s,
        "holes": len(recording.gaps),
        **told,
    }


def _make_row(path: Path, relative: str, origin: str) -> RecordingRow:
    row = RecordingRow(
        id=str(uuid.uuid4()), path=relative, origin=origin, size_octets=path.stat().st_size, details={}
    )
    try:
        recording = read_recording(path)
    except RecordingError as error:  # listed all the same: somebody may want to look at the file
        row.details = {"unreadable": str(error)}
        return row
    lost = sum(gap.missing_samples for gap in recording.gaps)
    row.samples, row.samples_lost = recording.n, lost
    row.duration_s = (recording.n + lost) * recording.sample_time_s
    row.details = describe_recording(recording)
    rig = recording.metadata.get("rig")
    row.rig_id = rig if isinstance(rig, str) else None
    return row
