"""Recordings as Parquet files: raw counts for what came off the wire, SI values for what came from elsewhere.

One file, one recording. Its story is JSON under the key `jointscope` of the schema metadata, so it travels
with the samples. Counts are stored as DELTA_BINARY_PACKED and zstd: an hour of three channels at 2.5 kHz
takes about 15 MB. A file appears under its name only when it is complete.
"""

import contextlib
import json
import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from daq.calibration.channels import ChannelCalibration, counts_to_si
from daq.errors import RecordingError
from daq.recording.derived_speed import SPEED_OF, derive_speed, speed_options
from daq.recording.gap_table import gaps_from_json, gaps_to_json
from daq.recording.recording import (
    TIME,
    FloatArray,
    GapSpan,
    LazyColumns,
    Metadata,
    Recording,
    segments_between,
)

AnyArray = np.ndarray[Any, np.dtype[Any]]

METADATA_KEY: Final = b"jointscope"
SCHEMA: Final = "jointscope.recording/1"
TICK: Final = "tick"
STATUS: Final = "status"
GAP: Final = "gap"
COUNTS_SUFFIX: Final = "_counts"
ROW_GROUP_ROWS: Final = 1 << 20


def counts_column(channel: str) -> str:
    """Return the name under which a channel's raw counts are stored."""
    return channel + COUNTS_SUFFIX


class CountsWriter:
    """Writes raw counts block by block into a Parquet file that appears when `finish` is called.

    Args:
        path: the file to be.
        columns: names and types of the columns.
    """

    def __init__(self, path: Path, columns: Mapping[str, np.dtype[Any]]) -> None:
        self.path = path
        self._partial = path.with_name(path.name + ".partial")
        self._schema = pa.schema([(name, pa.from_numpy_dtype(dtype)) for name, dtype in columns.items()])
        self._writer = pq.ParquetWriter(
            self._partial,
            self._schema,
            compression="zstd",
            use_dictionary=False,
            column_encoding={
                name: "DELTA_BINARY_PACKED" for name, dtype in columns.items() if dtype != np.bool_
            },
        )

    def write(self, columns: Mapping[str, Sequence[AnyArray]]) -> None:
        """Write one row group: the pieces of each column are joined in order."""
        arrays = [np.concatenate(columns[name]) for name in self._schema.names]
        table = pa.table(arrays, schema=self._schema)
        self._writer.write_table(table, row_group_size=len(table))

    def finish(self, metadata: Metadata) -> Path:
        """Add the metadata, force the file onto the medium and give it its name."""
        self._writer.add_key_value_metadata({METADATA_KEY: json.dumps(metadata).encode()})
        self._writer.close()
        publish(self._partial, self.path)
        return self.path

    def discard(self) -> None:
        """Remove what was written."""
        with contextlib.suppress(OSError):  # on a full disk not even the footer can be written
            self._writer.close()
        self._partial.unlink(missing_ok=True)


def publish(partial_path: Path, path: Path) -> None:
    """Force a finished file onto the medium, then give it its name in one step."""
    with partial_path.open("rb") as file:
        os.fsync(file.fileno())
    partial_path.replace(path)


def write_recording(recording: Recording, path: Path) -> Path:
    """Write a recording's SI columns, its holes and its metadata.

    Returns:
        `path`.
    """
    metadata = {
        **recording.metadata,
        "schema": SCHEMA,
        "units": dict(recording.units),
        "sample_time_s": recording.sample_time_s,
        "gaps": gaps_to_json(recording.gaps),
    }
    arrays = {name: recording.column(name) for name in recording.columns}
    table = pa.table({**arrays, GAP: recording.gap}).replace_schema_metadata(
        {METADATA_KEY: json.dumps(metadata)}
    )
    partial_path = path.with_name(path.name + ".partial")
    pq.write_table(
        table,
        partial_path,
        compression="zstd",
        use_dictionary=False,
        column_encoding=dict.fromkeys(arrays, "BYTE_STREAM_SPLIT"),
        row_group_size=ROW_GROUP_ROWS,
    )
    publish(partial_path, path)
    return path


def read_recording(path: Path) -> Recording:
    """Open a recording; its samples are read when a column is first asked for.

    Raises:
        RecordingError: there is no such file, it is no Parquet, or nobody of ours wrote it.
    """
    try:
        footer = pq.read_metadata(path)
    except (OSError, pa.ArrowInvalid) as error:
        raise RecordingError(f"cannot read recording {path}: {error}") from error
    stored = (footer.metadata or {}).get(METADATA_KEY)
    if stored is None:
        raise RecordingError(
            f"{path} is Parquet but no recording of Jointscope; bring it in by `jointscope import`"
        )
    metadata: dict[str, Any] = json.loads(stored)
    if metadata.get("schema") != SCHEMA:
        raise RecordingError(
            f"{path} has the schema {metadata.get('schema')!r}; this version reads {SCHEMA!r}"
        )
    gaps, n = gaps_from_json(metadata["gaps"]), footer.num_rows
    columns = (
        _counts_columns(path, metadata, gaps, n) if "calibration" in metadata else _si_columns(path, metadata)
    )
    return Recording(
        columns=columns,
        units=metadata["units"],
        gaps=gaps,
        metadata=metadata,
        sample_time_s=metadata["sample_time_s"],
        n=n,
    )


def read_counts(path: Path, column: str) -> AnyArray:
    """Read one stored column as it is in the file: `tick`, `status`, `gap`, or a channel's `NAME_counts`."""
    # Not pq.read_table: that loads Arrow's dataset engine first, which takes longer than reading an hour.
    with pq.ParquetFile(path) as file:
        values: AnyArray = file.read(columns=[column]).column(0).to_numpy()
    return values


def _si_columns(path: Path, metadata: Metadata) -> LazyColumns:
    return LazyColumns({name: partial(_read_float, path, name, _as_float) for name in metadata["units"]})


def _counts_columns(path: Path, metadata: Metadata, gaps: tuple[GapSpan, ...], n: int) -> LazyColumns:
    calibrations = [ChannelCalibration(**each) for each in metadata["calibration"]]
    measured = LazyColumns({each.column: partial(_read_channel, path, each) for each in calibrations})
    loaders: dict[str, Callable[[], FloatArray]] = {
        TIME: partial(_read_time, path, metadata["tick_hz"]),
        **measured.loaders(),
    }
    for position in SPEED_OF.keys() & measured.keys():
        loaders[SPEED_OF[position]] = partial(
            _read_speed, measured, position, metadata, segments_between(gaps, n)
        )
    return LazyColumns(loaders)


def _read_time(path: Path, tick_hz: float) -> FloatArray:
    time_s = _read_float(path, TICK, _as_float)
    time_s -= time_s[:1].copy()
    time_s /= tick_hz
    return time_s


def _read_channel(path: Path, calibration: ChannelCalibration) -> FloatArray:
    return _read_float(
        path, counts_column(calibration.channel), lambda counts: counts_to_si(counts, calibration)
    )


def _read_float(path: Path, column: str, convert: Callable[[AnyArray], FloatArray]) -> FloatArray:
    """Read one column, converted row group by row group, so that little is in memory beside the result."""
    with pq.ParquetFile(path) as file:
        values = np.empty(file.metadata.num_rows)
        row = 0
        for group in range(file.num_row_groups):
            for chunk in file.read_row_group(group, columns=[column]).column(0).iterchunks():
                # Not to_numpy: that loads pandas where it is installed, which takes longer than an estimate may.
                values[row : row + len(chunk)] = convert(np.from_dlpack(chunk))
                row += len(chunk)
    return values


def _as_float(stored: AnyArray) -> FloatArray:
    return stored.astype(np.float64, copy=False)


def _read_speed(
    measured: LazyColumns, position: str, metadata: Metadata, segments: tuple[slice, ...]
) -> FloatArray:
    return derive_speed(
        measured[position], segments, metadata["sample_time_s"], speed_options(metadata["speed"])
    )
