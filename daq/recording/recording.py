"""The recording as the rest of the program sees it: SI columns on a time axis, its holes, and its story.

Columns are loaded when first asked for, so that looking at the current of an hour's record does not decode
its position. A recording is read-only: every change makes a new one.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from daq.errors import RecordingError
from daq.recording.units import unit_of

FloatArray = npt.NDArray[np.float64]
# What json.loads returns: its type cannot be said more closely without casting at every use.
Metadata = Mapping[str, Any]

TIME = "time_s"


@dataclass(frozen=True, slots=True, kw_only=True)
class GapSpan:
    """One hole in the time axis.

    Attributes:
        row: index of the first sample after the hole; the number of samples for a hole at the end.
        start_s: time of the first missing sample, on the recording's time axis.
        missing_samples: how many samples are missing; for time bases that jitter, the nearest whole number; 0
            where
            nobody can know (the controller restarted).
        cause: value of the link's `GapCause` (loss, reconnect, ...), or `hole` where only the time axis shows
            it.
    """

    row: int
    start_s: float
    missing_samples: int
    cause: str


class LazyColumns(Mapping[str, FloatArray]):
    """Columns by name, each computed when first asked for and then kept, read-only."""

    def __init__(self, loaders: Mapping[str, Callable[[], FloatArray]]) -> None:
        self._loaders = dict(loaders)
        self._loaded: dict[str, FloatArray] = {}

    def __getitem__(self, name: str) -> FloatArray:
        if name not in self._loaded:
            values = self._loaders[name]()
            values.flags.writeable = False
            self._loaded[name] = values
        return self._loaded[name]

    def __contains__(self, name: object) -> bool:
        return name in self._loaders  # the inherited way would load the column to see whether it is there

    def __iter__(self) -> Iterator[str]:
        return iter(self._loaders)

    def __len__(self) -> int:
        return len(self._loaders)

    def loaders(self) -> dict[str, Callable[[], FloatArray]]:
        """Return what computes each column, for a recording that adds or replaces some."""
        return {name: partial(self.__getitem__, name) for name in self._loaders}


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """Measured columns on one time axis.

    Attributes:
        columns: SI values by contract name, float64 of shape (n,), each loaded on first use.
        units: unit of each column.
        gaps: holes of the time axis, in order.
        metadata: how the recording came to be; JSON values only.
        sample_time_s: nominal time between samples.
        n: number of samples.
    """

    columns: LazyColumns
    units: Mapping[str, str]
    gaps: tuple[GapSpan, ...] = ()
    metadata: Metadata = field(default_factory=dict)
    sample_time_s: float
    n: int

    def column(self, name: str) -> FloatArray:
        """Return one column, shape (n,), read-only.

        Raises:
            RecordingError: there is no such column.
        """
        if name not in self.columns:
            raise RecordingError(
                f"column {name!r} is missing; this recording has {', '.join(self.columns)}. "
                f"Import it with --map {name}=YOUR_NAME where it is called otherwise"
            )
        return self.columns[name]

    @property
    def time_s(self) -> FloatArray:
        """Time from the first sample in s, shape (n,)."""
        return self.column(TIME)

    @property
    def gap(self) -> npt.NDArray[np.bool_]:
        """Flags of shape (n,): True where samples are missing just before this one."""
        flags = np.zeros(self.n, dtype=np.bool_)
        flags[[span.row for span in self.gaps if span.row < self.n]] = True
        return flags

    @property
    def duration_s(self) -> float:
        """Time from the first to the last sample in s."""
        return float(self.time_s[-1] - self.time_s[0]) if self.n else 0.0

    def segments(self) -> tuple[slice, ...]:
        """Return the runs of rows without a hole, in order."""
        return segments_between(self.gaps, self.n)


def segments_between(gaps: Iterable[GapSpan], n: int) -> tuple[slice, ...]:
    """Return the runs of rows that the gaps leave of n rows, in order."""
    edges = [0, *(span.row for span in gaps), n]
    return tuple(slice(a, b) for a, b in pairwise(edges) if b > a)


def recording_from_columns(
    columns: Mapping[str, npt.ArrayLike],
    *,
    sample_time_s: float,
    gaps: tuple[GapSpan, ...] = (),
    units: Mapping[str, str] | None = None,
    metadata: Metadata | None = None,
) -> Recording:
    """Make a recording of arrays in memory.

    Args:
        columns: equal-length values by name, `time_s` among them; the arrays are copied.
        sample_time_s: nominal time between samples.
        gaps: holes of the time axis.
        units: units of columns whose name does not end in one.
        metadata: JSON values.

    Raises:
        RecordingError: no time axis, unequal lengths, or a column without a unit.
    """
    arrays = {name: np.array(values, dtype=np.float64) for name, values in columns.items()}
    if TIME not in arrays:
        raise RecordingError(f"column {TIME!r} is missing; there are {', '.join(arrays) or 'no columns'}")
    n = len(arrays[TIME])
    for name, values in arrays.items():
        if values.shape != (n,):
            raise RecordingError(f"column {name!r} has shape {values.shape}; {TIME} has {n} samples")
    known = {name: (units or {}).get(name) or unit_of(name) for name in arrays}
    unitless = [name for name, unit in known.items() if unit is None]
    if unitless:
        raise RecordingError(
            f"columns without a unit: {', '.join(unitless)}; let the name end in one (current_A)"
        )
    return Recording(
        columns=LazyColumns({name: partial(np.asarray, values) for name, values in arrays.items()}),
        units={name: unit for name, unit in known.items() if unit is not None},
        gaps=gaps,
        metadata=metadata or {},
        sample_time_s=sample_time_s,
        n=n,
    )


def cut(recording: Recording, start_s: float, stop_s: float) -> Recording:
    """Return the samples with start_s <= time_s < stop_s, on the same time axis.

    Raises:
        RecordingError: no sample lies in this span.
    """
    first, last = (int(row) for row in np.searchsorted(recording.time_s, [start_s, stop_s]))
    if last <= first:
        raise RecordingError(
            f"no sample between {start_s:g} s and {stop_s:g} s; the recording covers "
            f"{recording.time_s[0]:g} s to {recording.time_s[-1]:g} s"
        )
    gaps = tuple(
        GapSpan(
            row=span.row - first, start_s=span.start_s, missing_samples=span.missing_samples, cause=span.cause
        )
        for span in recording.gaps
        if first < span.row < last
    )
    return recording_from_columns(
        {name: recording.column(name)[first:last] for name in recording.columns},
        sample_time_s=recording.sample_time_s,
        gaps=gaps,
        units=recording.units,
        metadata={**recording.metadata, "cut_s": [start_s, stop_s]},
    )
