"""What recordings there are: list by filter and page, look up, delete with a period of grace, take back, purge.

Deleting marks a recording and sets the day on which a thread removes its files; until then it can be taken back. A
purged recording keeps its row, since models and analyses were made of it.
"""

import logging
import threading
from collections.abc import Sequence
from datetime import timedelta
from pathlib import Path

import sqlalchemy as sa

from daq.recording.journal_reader import ARCHIVE_SUFFIX
from server.services.errors import ConflictError
from server.services.recordings.listing import RecordingFilter, RecordingPage, read_page
from server.services.recordings.views import RecordingView, find_row, view_of
from server.storage.database import Database
from server.storage.tables import RecordingRow
from server.storage.types import utc_now

_LOG = logging.getLogger(__name__)
_PURGE_EVERY_S = 600.0


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
        return read_page(self._database, wanted, cursor, limit)

    def get(self, recording_id: str) -> RecordingView:
        """Return one recording, deleted or not.

        Raises:
            NotFoundError: there is none of this id.
        """
        with self._database.read() as session:
            return view_of(find_row(session.get(RecordingRow, recording_id), recording_id))

    def path(self, recording_id: str) -> Path:
        """Return the file of a recording that is not deleted.

        Raises:
            NotFoundError: there is none of this id.
            ConflictError: it is deleted, or its file is gone.
        """
        with self._database.read() as session:
            row = find_row(session.get(RecordingRow, recording_id), recording_id)
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
            row = find_row(session.get(RecordingRow, recording_id), recording_id)
            if row.deleted_at is None:
                row.deleted_at = utc_now()
                row.purge_at = row.deleted_at + self._grace
            return view_of(row)

    def undelete(self, recording_id: str) -> RecordingView:
        """Take a deletion back.

        Raises:
            NotFoundError: there is none of this id.
            ConflictError: its files are gone.
        """
        with self._database.write() as session:
            row = find_row(session.get(RecordingRow, recording_id), recording_id)
            if row.details.get("purged"):
                raise ConflictError(f"the files of the recording {row.name!r} are gone", "record it again")
            row.deleted_at = row.purge_at = None
            return view_of(row)

    def purge(self, recording_id: str) -> RecordingView:
        """Remove the files of a deleted recording now.

        Raises:
            NotFoundError: there is none of this id.
            ConflictError: it is not deleted.
        """
        with self._database.write() as session:
            row = find_row(session.get(RecordingRow, recording_id), recording_id)
            if row.deleted_at is None:
                raise ConflictError(f"the recording {row.name!r} is not deleted", "DELETE it first")
            if row.details.get("purged"):
                return view_of(row)
            path = self._data_dir / row.path
            # The row first: a row without files can be purged again, files without a row are never found.
            row.details = {**row.details, "purged": True}
            row.path, row.size_octets = f"purged/{row.id}", 0
            view = view_of(row)
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
