"""Import and export of recordings, and the one way in which every service opens a recording."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from daq.errors import RecordingError
from daq.recording.recording import Recording, cut
from server.errors import InputError, InputLocation


@dataclass(frozen=True, slots=True, kw_only=True)
class ImportRequest:
    """What to import.

    Attributes:
        source: CSV, CSV.gz, Parquet, MAT or HDF5 file.
        mappings: `NEW=OLD`, `NEW=OLD*FACTOR` or `NEW=OLD[UNIT]`, one for each column to rename or convert.
        leave_out: columns not to take.
        span_s: first and last time to take, from the file's first sample; None takes everything.
    """

    source: Path
    mappings: Sequence[str] = ()
    leave_out: Sequence[str] = ()
    span_s: tuple[float, float] | None = None


def open_recording(path: Path) -> Recording:
    """Open a recording, or a foreign file whose columns already have our names.

    Raises:
        InputError: no such file, or not fit to be a recording.
    """
    # Here, since every command knows this module and only some read files.
    from daq.exchange.importing import load_recording

    if not path.is_file():
        raise InputError("no such file", InputLocation(source=path))
    try:
        return load_recording(path)
    except RecordingError as error:
        raise _at(path, error) from error


def import_recording(request: ImportRequest, out: Path) -> Recording:
    """Import a foreign file and write it as a recording.

    Raises:
        InputError: unreadable, wrong mapping, missing column, NaN, or a time axis that is none.
    """
    from daq.exchange.importing import import_file
    from daq.exchange.mapping import parse_mappings
    from daq.recording.store import write_recording

    if out.suffix != ".parquet":
        raise InputError(
            "a recording is a Parquet file; let the name end in .parquet", InputLocation(source=out)
        )
    if not request.source.is_file():
        raise InputError("no such file", InputLocation(source=request.source))
    try:
        recording = import_file(
            request.source, parse_mappings(request.mappings), leave_out=tuple(request.leave_out)
        )
        if request.span_s is not None:
            recording = cut(recording, *request.span_s)
    except RecordingError as error:
        raise _at(request.source, error) from error
    out.parent.mkdir(parents=True, exist_ok=True)
    write_recording(recording, out)
    return recording


def export_file(source: Path, out: Path) -> Path:
    """Export a recording; the format follows from the ending of `out`.

    Raises:
        InputError: no such recording, an unknown ending, or a library that is not installed.
    """
    from daq.exchange.exporting import export_recording, format_of

    try:
        export_format = format_of(out)
    except RecordingError as error:
        raise InputError(str(error)) from error
    recording = open_recording(source)
    out.parent.mkdir(parents=True, exist_ok=True)
    return export_recording(recording, out, export_format)


def _at(path: Path, error: RecordingError) -> InputError:
    """Name the file once: some messages already do."""
    text = str(error)
    return InputError(text) if str(path) in text else InputError(text, InputLocation(source=path))
