"""Samples of a recording for whoever asks: a span of time, chosen columns, thinned out, as JSON or Arrow."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from daq.errors import RecordingError
from daq.recording.recording import TIME, Recording
from daq.recording.store import GAP, read_recording
from server.services.errors import InvalidValueError

MAX_JSON_VALUES = 1_000_000
ARROW_BATCH_ROWS = 1 << 16
Columns = dict[str, npt.NDArray[Any]]  # float64 values and boolean flags


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleRequest:
    """Which samples.

    Attributes:
        columns: by name; none takes all. `time_s` and `gap` always come along.
        start_s, stop_s: span of the recording's time axis, the end excluded; None is open.
        every: take every so manieth sample; there is no filter, so what is faster folds back.
        points: instead, minimum and maximum of each column over so many pieces of equal length.
    """

    columns: Sequence[str] = ()
    start_s: float | None = None
    stop_s: float | None = None
    every: int = 1
    points: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Samples:
    """Equal-length columns.

    Attributes:
        columns: `time_s` first, `gap` last: samples are missing just before. With `points`, `NAME_min` and `NAME_max`.
        units: unit of each column but `gap`.
        rows: how many there are.
        of_rows: how many samples the span has.
        sample_time_s: nominal time between the recording's samples.
    """

    columns: Columns
    units: Mapping[str, str]
    rows: int
    of_rows: int
    sample_time_s: float


def read_samples(path: Path, request: SampleRequest) -> Samples:
    """Read samples from a recording's file.

    Raises:
        InvalidValueError: no such column, or `every` beside `points`.
        RecordingError: the file is damaged.
    """
    if request.every > 1 and request.points is not None:
        raise InvalidValueError(
            "every and points exclude each other",
            field="points",
            value=request.points,
            remedy="leave one of them out",
        )
    recording = read_recording(path)
    names = _choose(recording, request.columns)
    span = _span(recording, request)
    if request.points is None:
        rows = slice(span.start, span.stop, request.every)
        columns: Columns = {name: recording.column(name)[rows] for name in names}
        columns[GAP] = _gaps_kept(recording.gap[span], request.every)
        units = {name: recording.units[name] for name in names}
    else:
        columns = _extremes(recording, names, span, request.points)
        units = {
            name: recording.units[name.removesuffix("_min").removesuffix("_max")]
            for name in columns
            if name != GAP
        }
    return Samples(
        columns=columns,
        units=units,
        rows=len(columns[TIME]),
        of_rows=span.stop - span.start,
        sample_time_s=recording.sample_time_s,
    )


def as_json(samples: Samples) -> bytes:
    """Return samples as a JSON document; what is not finite becomes null.

    Raises:
        InvalidValueError: more values than JSON is fit for.
    """
    values = samples.rows * len(samples.columns)
    if values > MAX_JSON_VALUES:
        raise InvalidValueError(
            f"{samples.rows} rows of {len(samples.columns)} columns are too many for JSON, "
            f"which takes {MAX_JSON_VALUES:,} values",
            field="points",
            value=None,
            remedy="give points=2000 to draw it, a shorter span, or Accept: application/vnd.apache.arrow.stream",
        )
    document = {
        "rows": samples.rows,
        "of_rows": samples.of_rows,
        "sample_time_s": samples.sample_time_s,
        "units": dict(samples.units),
        "columns": {name: _listed(column) for name, column in samples.columns.items()},
    }
    return json.dumps(document, allow_nan=False).encode()


def as_arrow(samples: Samples) -> bytes:
    """Return samples as an Arrow IPC stream; units and sample time stand in the schema's metadata."""
    import pyarrow as pa  # slow to import, needed only here

    facts = {
        "rows": str(samples.rows),
        "of_rows": str(samples.of_rows),
        "sample_time_s": repr(samples.sample_time_s),
        "units": json.dumps(dict(samples.units)),
    }
    table = pa.table(samples.columns).replace_schema_metadata(facts)
    sink = pa.BufferOutputStream()
    with pa.ipc.new_stream(sink, table.schema) as writer:
        writer.write_table(table, max_chunksize=ARROW_BATCH_ROWS)
    octets: bytes = sink.getvalue().to_pybytes()
    return octets


def _choose(recording: Recording, wanted: Sequence[str]) -> list[str]:
    names = [name for name in (wanted or recording.columns) if name not in (TIME, GAP)]
    for name in names:
        if name not in recording.columns:
            raise InvalidValueError(
                f"this recording has no column {name!r}",
                field="column",
                value=name,
                remedy=f"it has {', '.join(recording.columns)}",
            )
    return [TIME, *dict.fromkeys(names)]


def _span(recording: Recording, request: SampleRequest) -> slice:
    try:
        time_s = recording.time_s
    except (OSError, KeyError, ValueError) as error:
        raise RecordingError(f"the recording's samples cannot be read: {error}") from error
    first = 0 if request.start_s is None else int(np.searchsorted(time_s, request.start_s))
    last = recording.n if request.stop_s is None else int(np.searchsorted(time_s, request.stop_s))
    return slice(first, max(first, last))


def _gaps_kept(gap: npt.NDArray[np.bool_], every: int) -> npt.NDArray[np.bool_]:
    """Keep each hole at the first sample behind it that is taken."""
    if every == 1 or not len(gap):
        return gap
    before = np.concatenate(([0], np.cumsum(gap)))[np.append(np.arange(0, len(gap), every) + 1, 0)]
    flags: npt.NDArray[np.bool_] = np.diff(before[:-1], prepend=0) > 0
    return flags


def _extremes(recording: Recording, names: Sequence[str], span: slice, points: int) -> Columns:
    """Return minimum and maximum over pieces, with the time at which each piece begins."""
    n = span.stop - span.start
    starts = np.linspace(0, n, min(points, n), endpoint=False).astype(np.int64)
    columns: Columns = {TIME: recording.time_s[span][starts]}
    for name in names[1:]:
        values = recording.column(name)[span]
        for ending, extreme in (("_min", np.minimum), ("_max", np.maximum)):
            columns[name + ending] = extreme.reduceat(values, starts) if n else values
    flags = recording.gap[span]
    columns[GAP] = np.logical_or.reduceat(flags, starts) if n else flags
    return columns


def _listed(column: npt.NDArray[Any]) -> list[Any]:  # numbers, flags and null
    values: list[Any] = column.tolist()
    if column.dtype.kind != "f" or np.isfinite(column).all():
        return values
    return [value if np.isfinite(value) else None for value in values]
