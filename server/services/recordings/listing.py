"""Lists of recordings: filters, and pages that continue where the last one ended, whatever came meanwhile."""

import base64
import binascii
from dataclasses import dataclass, field
from datetime import UTC, datetime

import sqlalchemy as sa

from server.services.errors import InvalidValueError
from server.services.recordings.views import RecordingView, view_of
from server.storage.database import Database
from server.storage.tables import RecordingRow


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


def read_page(database: Database, wanted: RecordingFilter, cursor: str | None, limit: int) -> RecordingPage:
    """Return one page, newest first.

    Args:
        database: where recordings are listed.
        wanted: which.
        cursor: of the page before; None for the first.
        limit: recordings on a page.

    Raises:
        InvalidValueError: the cursor is none of ours, or a time that no calendar has.
    """
    newest = (RecordingRow.created_at.desc(), RecordingRow.id.desc())
    query = sa.select(RecordingRow).where(*_conditions(wanted)).order_by(*newest).limit(limit + 1)
    if cursor is not None:
        created_at, recording_id = _read_cursor(cursor)
        query = query.where(_is_older(created_at, recording_id))
    with database.read() as session:
        rows = list(session.scalars(query))
    following = _write_cursor(rows[limit - 1]) if len(rows) > limit else None
    return RecordingPage(items=[view_of(row) for row in rows[:limit]], cursor=following)


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
