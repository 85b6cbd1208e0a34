"""What recordings there are: list by filter and page, look up, delete with a period of grace, take back, purge.

Deleting marks a recording and sets the day on which a thread removes its files; until then it can be taken back. A
purged recording keeps its row, since models and analyses were made of it.
"""

import base64
import binascii
import logging
import threading
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from daq.recording.journal_reader import ARCHIVE_SUFFIX
from server.services.errors import ConflictError, InvalidValueError, NotFoundError
from server.storage.database import Database
from server.storage.tables import RecordingRow
from server.storage.types import utc_now

_LOG = logging.getLogger(__name__)
_PURGE_EVERY_S = 600.0
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


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingFilter:
    """Which recordings to list; None does not ask.

    Attributes:
        since, until: made in this span of time; without a zone, UTC.
        column: has this column.
        text: part of its name, whatever the case.
        deleted: those that are deleted instead of those that are not.
    """

    rig_id: str | None = None
    session_id: str | None = None
    campaign_id: str | None = None
    origin: str | None = None
    since: datetime | None = None
    until: datetime | None = None
    column: str | None = None
    text: str | None = None
    deleted: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingPage:
    """Newest first; `cursor` continues, None at the end."""

    items: list[RecordingView] = field(default_factory=list)
    cursor: str | None = None


class RecordingCatalogue:
    """Lists, finds and deletes recordings.

    Args:
        database: where they are listed.
        data_dir: where their files are.
        grace: from deletion to the removal of the files.
    """

    def __init__(self, database: Database, data_dir: Path, grace: timedelta) -> None:
        self._database = database
        self._data_dir = data_dir
        self._grace = grace
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._keep_purging, name="jointscope-purge", daemon=True)

    def start(self) -> None:
        """Begin to remove the files of those whose grace is over."""
        self._thread.start()

    def close(self) -> None:
        """End the thread."""
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join()

    def page(self, wanted: RecordingFilter, *, cursor: str | None = None, limit: int = 100) -> RecordingPage:
        """Return one page, newest first.

        Raises:
            InvalidValueError: the cursor is none of ours, or a time that no calendar has.
        """
        newest = (RecordingRow.created_at.desc(), RecordingRow.id.desc())
        query = sa.select(RecordingRow).where(*_conditions(wanted)).order_by(*newest).limit(limit + 1)
        if cursor is not None:
            created_at, recording_id = _read_cursor(cursor)
            query = query.where(_is_older(created_at, recording_id))
        with self._database.read() as session:
            rows = list(session.scalars(query))
        following = _write_cursor(rows[limit - 1]) if len(rows) > limit else None
        return RecordingPage(items=[_view(row) for row in rows[:limit]], cursor=following)

    def get(self, recording_id: str) -> RecordingView:
        """Return one recording, deleted or not.

        Raises:
            NotFoundError: there is none of this id.
        """
        with self._database.read() as session:
            return _view(_find(session.get(RecordingRow, recording_id), recording_id))

    def path(self, recording_id: str) -> Path:
        """Return the file of a recording that is not deleted.

        Raises:
            NotFoundError: there is none of this id.
            ConflictError: it is deleted, or its file is gone.
        """
        with self._database.read() as session:
            row = _find(session.get(RecordingRow, recording_id), recording_id)
        if row.deleted_at is not None:
            raise ConflictError(
                f"the recording {row.name!r} is deleted", f"POST /api/v1/recordings/{row.id}/undelete first"
            )
        path = self._data_dir / row.path
        if not path.is_file():
            raise ConflictError(
                f"the file of the recording {row.name!r} is gone", "restore the data folder from a backup"
            )
        return path

    def relative_paths(self, ids: Sequence[str]) -> list[str]:
        """Return the files of several recordings, relative to the data folder.

        Raises:
            NotFoundError, ConflictError: as for `path`.
        """
        return [str(self.path(each).relative_to(self._data_dir)) for each in ids]

    def delete(self, recording_id: str) -> RecordingView:
        """Mark a recording as deleted; its files go when its grace is over.

        Raises:
            NotFoundError: there is none of this id.
        """
        with self._database.write() as session:
            row = _find(session.get(RecordingRow, recording_id), recording_id)
            if row.deleted_at is None:
                row.deleted_at = utc_now()
                row.purge_at = row.deleted_at + self._grace
            return _view(row)

    def undelete(self, recording_id: str) -> RecordingView:
        """Take a deletion back.

        Raises:
            NotFoundError: there is none of this id.
            ConflictError: its files are gone.
        """
        with self._database.write() as session:
            row = _find(session.get(RecordingRow, recording_id), recording_id)
            if row.details.get("purged"):
                raise ConflictError(f"the files of the recording {row.name!r} are gone", "record it again")
            row.deleted_at = row.purge_at = None
            return _view(row)

    def purge(self, recording_id: str) -> RecordingView:
        """Remove the files of a deleted recording now.

        Raises:
            NotFoundError: there is none of this id.
            ConflictError: it is not deleted.
        """
        with self._database.write() as session:
            row = _find(session.get(RecordingRow, recording_id), recording_id)
            if row.deleted_at is None:
                raise ConflictError(f"the recording {row.name!r} is not deleted", "DELETE it first")
            if row.details.get("purged"):
                return _view(row)
            path = self._data_dir / row.path
            # The row first: a row without files can be purged again, files without a row are never found.
            row.details = {**row.details, "purged": True}
            row.path, row.size_octets = f"purged/{row.id}", 0
            view = _view(row)
        _remove_files(path)
        return view

    def purge_due(self) -> int:
        """Remove the files of all whose grace is over, and return how many there were."""
        due = sa.select(RecordingRow.id).where(
            RecordingRow.purge_at <= utc_now(), RecordingRow.path.not_like("purged/%")
        )
        with self._database.read() as session:
            ids = list(session.scalars(due))
        for each in ids:
            self.purge(each)
        return len(ids)

    def _keep_purging(self) -> None:
        while True:
            try:
                self.purge_due()
            except (OSError, sa.exc.SQLAlchemyError):  # tried again later
                _LOG.exception("deleted recordings could not be purged")
            if self._closing.wait(_PURGE_EVERY_S):
                return


def _remove_files(path: Path) -> None:
    """Remove a recording's file, and the archived journal that it was made of."""
    path.unlink(missing_ok=True)
    path.with_name(path.stem + ARCHIVE_SUFFIX).unlink(missing_ok=True)


def _find(row: RecordingRow | None, recording_id: str) -> RecordingRow:
    if row is None:
        raise NotFoundError("recording", recording_id, _REMEDY)
    return row


def _conditions(wanted: RecordingFilter) -> list[sa.ColumnElement[bool]]:
    exact = {
        RecordingRow.rig_id: wanted.rig_id,
        RecordingRow.session_id: wanted.session_id,
        RecordingRow.campaign_id: wanted.campaign_id,
        RecordingRow.origin: wanted.origin,
    }
    found = [column == value for column, value in exact.items() if value is not None]
    gone = RecordingRow.deleted_at.is_not(None)
    found.append(gone if wanted.deleted else sa.not_(gone))
    if wanted.since is not None:
        found.append(RecordingRow.created_at >= _in_utc(wanted.since, "since"))
    if wanted.until is not None:
        found.append(RecordingRow.created_at < _in_utc(wanted.until, "until"))
    if wanted.column is not None:
        found.append(RecordingRow.details[("columns", wanted.column)].as_string().is_not(None))
    if wanted.text is not None:
        found.append(RecordingRow.name.icontains(wanted.text, autoescape=True))
    return found


def _in_utc(value: datetime, name: str) -> datetime:
    try:
        return value.replace(tzinfo=UTC) if value.tzinfo is None else value.astimezone(UTC)
    except OverflowError as error:
        raise InvalidValueError(
            f"{name}={value.isoformat()} lies outside the calendar",
            field=name,
            value=value.isoformat(),
            remedy="give a time between the years 1 and 9999 in UTC",
        ) from error


def _is_older(created_at: datetime, recording_id: str) -> sa.ColumnElement[bool]:
    same = sa.and_(RecordingRow.created_at == created_at, RecordingRow.id < recording_id)
    return sa.or_(RecordingRow.created_at < created_at, same)


def _write_cursor(row: RecordingRow) -> str:
    return base64.urlsafe_b64encode(f"{row.created_at.isoformat()} {row.id}".encode()).decode()


def _read_cursor(cursor: str) -> tuple[datetime, str]:
    try:
        moment, recording_id = base64.urlsafe_b64decode(cursor.encode()).decode().split(" ")
        return _in_utc(datetime.fromisoformat(moment), "cursor"), recording_id
    except (binascii.Error, UnicodeError, ValueError) as error:
        raise InvalidValueError(
            "this cursor is none of ours",
            field="cursor",
            value=cursor,
            remedy="take `cursor` of the page before, or leave it out for the first page",
        ) from error


def _view(row: RecordingRow) -> RecordingView:
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
