"""Makes a recording of a file that others wrote; its metadata say where it came from and what was left out.

Columns are known by name. Those whose names already end in one of our units are taken as they are, those that
a mapping names are renamed and converted, all others are left out and listed. Nothing is repaired: a NaN, a
time that runs backwards or a missing time axis is refused with its place.
"""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from daq.errors import RecordingError
from daq.exchange.mapping import ColumnMapping
from daq.exchange.readers import Columns, read_columns
from daq.recording.checks import require_columns
from daq.recording.header import software_versions
from daq.recording.recording import TIME, Recording, recording_from_columns
from daq.recording.store import GAP, METADATA_KEY, read_recording
from daq.recording.timebase import analyse_time_base
from daq.recording.units import unit_of

_HASH_CHUNK = 1 << 20


def import_file(
    path: Path, mappings: Sequence[ColumnMapping] = (), *, leave_out: Sequence[str] = ()
) -> Recording:
    """Read a foreign file as a recording.

    Args:
        path: CSV, CSV.gz, Parquet, MAT (v5 and v7.3) or HDF5.
        mappings: columns to rename and convert.
        leave_out: columns of the file not to take.

    Returns:
        The recording, in memory; `time_s` begins at 0. Holes of the time axis are in its gap table.

    Raises:
        RecordingError: unreadable, a column missing, NaN, or a time axis that is none; the message says
            where.
    """
    found = read_columns(path)
    columns = _take_columns(found, mappings, leave_out)
    if TIME not in columns:
        raise RecordingError(
            f"{path} has no column {TIME!r}, only {', '.join(found)}; name it with --map time_s=YOUR_TIME"
        )
    start_s = float(columns[TIME][0]) if len(columns[TIME]) else 0.0
    columns[TIME] = columns[TIME] - start_s
    recording = _with_time_base(columns, _describe_source(path, found, mappings, columns, start_s))
    require_columns(recording, recording.columns)
    return recording


def load_recording(path: Path) -> Recording:
    """Open a recording of ours, or any file whose columns already have our names.

    Raises:
        RecordingError: unreadable, or not fit to be a recording.
    """
    if path.suffix == ".parquet" and path.is_file():
        import pyarrow as pa  # slow to import, needed only here
        import pyarrow.parquet as pq

        try:
            stored = pq.read_metadata(path).metadata or {}
        except pa.ArrowInvalid as error:
            raise RecordingError(f"cannot read recording {path}: {error}") from error
        if METADATA_KEY in stored:
            return read_recording(path)
    return import_file(path)


def _take_columns(found: Columns, mappings: Sequence[ColumnMapping], leave_out: Sequence[str]) -> Columns:
    unknown = [name for name in (*(m.source for m in mappings), *leave_out) if name not in found]
    if unknown:
        raise RecordingError(f"column {unknown[0]!r} is not in the file; it has {', '.join(found)}")
    mapped = {mapping.source for mapping in mappings}
    columns = {
        name: values
        for name, values in found.items()
        if unit_of(name) is not None and name not in mapped and name not in leave_out and name != GAP
    }
    for mapping in mappings:
        columns[mapping.name] = found[mapping.source] * mapping.factor
    return columns


def _with_time_base(columns: Columns, metadata: Mapping[str, Any]) -> Recording:
    report = analyse_time_base(columns[TIME])
    return recording_from_columns(
        columns,
        sample_time_s=report.sample_time_s,
        gaps=report.holes,
        metadata={**metadata, "time_base": report.to_dict()},
    )


def _describe_source(
    path: Path, found: Columns, mappings: Sequence[ColumnMapping], columns: Columns, start_s: float
) -> dict[str, Any]:
    taken = {mapping.source for mapping in mappings} | columns.keys()
    return {
        "source": {
            "file": path.name,
            "sha256": _file_hash(path),
            "mappings": [asdict(mapping) for mapping in mappings],
            "left_out": [name for name in found if name not in taken],
            "time_offset_s": start_s,
        },
        "software": software_versions(),
    }


def _file_hash(path: Path) -> str:
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while chunk := file.read(_HASH_CHUNK):
            digest.update(chunk)
    return digest.hexdigest()
