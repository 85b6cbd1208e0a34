"""Files that come in and go out: measured files of others become recordings, recordings become files of others.

An upload is written to disk as it comes, then read by an importer in a process of its own, which takes numbers and
nothing else: no file is ever executed or unpickled. Half an upload, and files made for a download, are below `tmp/`,
which every start empties.
"""

import shutil
import uuid
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path, PurePosixPath
from typing import BinaryIO

from daq.errors import RecordingError
from daq.exchange.exporting import FILE_SUFFIXES, ExportFormat, export_recording
from daq.exchange.mapping import parse_mappings
from daq.exchange.readers import READERS
from daq.recording.store import read_recording
from server.errors import InputError
from server.services.errors import InvalidValueError
from server.services.recordings.catalogue import RecordingCatalogue
from server.services.recordings.importing import EXPANSION, ImportTask, memory_limit, run_import
from server.services.recordings.register import Listing, register_recording
from server.services.recordings.views import RecordingView
from server.storage.database import Database

FOLDER = "recordings"
TEMPORARY = "tmp"


class DownloadFormat(StrEnum):
    """What a recording can be downloaded as; `stored` is the file as it is kept, raw counts included."""

    STORED = "stored"
    PARQUET = "parquet"
    CSV = "csv"
    MAT = "mat"
    HDF5 = "hdf5"
    MDF4 = "mdf4"
    MCAP = "mcap"


@dataclass(frozen=True, slots=True, kw_only=True)
class Upload:
    """What is said of an uploaded file.

    Attributes:
        file_name: its name; the ending says what it is.
        name: of the recording; None takes the file's.
        mappings: `NEW=OLD`, `NEW=OLD*FACTOR` or `NEW=OLD[UNIT]`.
        leave_out: columns not to take.
        span_s: first and last time to take; None takes everything.
        created_by: name of the token.
    """

    file_name: str
    name: str | None = None
    mappings: tuple[str, ...] = ()
    leave_out: tuple[str, ...] = ()
    span_s: tuple[float, float] | None = None
    created_by: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Download:
    """A file to send; `discard` removes it afterwards if it was made for this."""

    path: Path
    name: str
    discard: Callable[[], None]


class IncomingFile:
    """An upload on its way to disk; a context manager that removes it at the end.

    Args:
        folder: made for it alone.
        file_name: what its user calls it, without folders.
    """

    def __init__(self, folder: Path, file_name: str) -> None:
        self.path = folder / file_name
        self._folder = folder
        folder.mkdir(parents=True)
        self._file: BinaryIO = self.path.open("wb")

    def write(self, octets: bytes) -> None:
        """Append octets."""
        self._file.write(octets)

    def finish(self) -> Path:
        """End the writing and return the file."""
        self._file.close()
        return self.path

    def discard(self) -> None:
        """Remove it."""
        self._file.close()
        shutil.rmtree(self._folder, ignore_errors=True)


class RecordingFiles:
    """Takes uploads and makes downloads.

    Args:
        database: where recordings are listed.
        data_dir: where files are.
        catalogue: finds them again.
        max_octets: largest upload.
    """

    def __init__(
        self, database: Database, data_dir: Path, catalogue: RecordingCatalogue, max_octets: int
    ) -> None:
        self._database = database
        self._data_dir = data_dir
        self._catalogue = catalogue
        self._max_octets = max_octets
        shutil.rmtree(data_dir / TEMPORARY, ignore_errors=True)

    def begin(self, upload: Upload) -> IncomingFile:
        """Open a file for an upload.

        Raises:
            InvalidValueError: a name whose ending no importer knows, or wrong mappings.
        """
        name = PurePosixPath(upload.file_name.replace("\\", "/")).name
        if not name.lower().endswith(tuple(READERS)) or len(name.encode()) > 200 or "\0" in name:
            raise InvalidValueError(
                f"{upload.file_name!r} is not the name of a file that can be imported",
                field="file",
                value=upload.file_name,
                remedy=f"let it end in one of {', '.join(READERS)}",
            )
        try:
            parse_mappings(upload.mappings)
        except RecordingError as error:
            raise InvalidValueError(
                str(error), field="map", value=", ".join(upload.mappings), remedy="see docs/recordings.md"
            ) from error
        return IncomingFile(self._data_dir / TEMPORARY / str(uuid.uuid4()), name)

    def take(self, incoming: IncomingFile, upload: Upload) -> RecordingView:
        """Make a recording of a file that has arrived.

        Raises:
            InputError: no measurement: unreadable, a missing column, NaN, a time axis that is none.
        """
        path = incoming.finish()
        if path.stat().st_size == 0:
            raise InputError(f"{path.name}: the file is empty; send its content as the body")
        target = self._data_dir / FOLDER / str(uuid.uuid4()) / (_stem(path) + ".parquet")
        target.parent.mkdir(parents=True)
        try:
            self._import(path, upload, target)
        except BaseException:
            shutil.rmtree(target.parent, ignore_errors=True)
            raise
        listing = Listing(name=upload.name or _stem(path), created_by=upload.created_by)
        recording_id = register_recording(
            self._database, self._data_dir, target, origin="upload", listing=listing
        )
        return self._catalogue.get(recording_id)

    def export(self, recording_id: str, wanted: DownloadFormat) -> Download:
        """Make a file of a recording.

        Raises:
            NotFoundError, ConflictError: there is no such recording, or it is deleted.
            RecordingError: the format needs a library that is not installed.
        """
        source = self._catalogue.path(recording_id)
        if wanted is DownloadFormat.STORED:
            return Download(path=source, name=source.name, discard=lambda: None)
        export_format = ExportFormat(wanted.value)
        folder = self._data_dir / TEMPORARY / str(uuid.uuid4())
        folder.mkdir(parents=True)
        path = folder / (source.stem + FILE_SUFFIXES[export_format])
        try:
            export_recording(read_recording(source), path, export_format)
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        return Download(path=path, name=path.name, discard=lambda: shutil.rmtree(folder, ignore_errors=True))

    def _import(self, path: Path, upload: Upload, target: Path) -> None:
        run_import(
            ImportTask(
                source=str(path),
                target=str(target),
                mappings=upload.mappings,
                leave_out=upload.leave_out,
                span_s=upload.span_s,
                memory_octets=memory_limit(self._max_octets),
                unpacked_octets=EXPANSION * self._max_octets,
            )
        )


def _stem(path: Path) -> str:
    """Return a file's name without its endings."""
    return path.name.split(".")[0] or "recording"
