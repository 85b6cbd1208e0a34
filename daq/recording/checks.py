"""Checks at the door: is a recording fit for what is asked of it? Refusals say what, where and how many."""

from collections.abc import Iterable

import numpy as np

from daq.errors import RecordingError
from daq.recording.recording import TIME, FloatArray, Recording
from daq.recording.timebase import check_time
from daq.recording.units import unit_of


def require_columns(recording: Recording, names: Iterable[str]) -> None:
    """Refuse a recording unless its columns are there, in their units, finite, on an increasing time axis.

    Args:
        recording: what was read.
        names: columns that will be used; `time_s` is always checked.

    Raises:
        RecordingError: naming the column, and for bad values their number, first row and time.
    """
    check_time(recording.time_s)
    for name in names:
        values = recording.column(name)
        require_unit(name, recording.units[name])
        require_finite(name, values, recording.time_s)


def require_unit(name: str, unit: str) -> None:
    """Refuse a column whose stated unit is not the one that its name ends in.

    Raises:
        RecordingError: naming both units.
    """
    expected = unit_of(name)
    if expected is not None and unit != expected:
        raise RecordingError(
            f"column {name!r} is stated in {unit!r} but its name says {expected!r}; "
            f"import it again with --map {name}=YOUR_NAME[{unit}]"
        )


def require_finite(name: str, values: FloatArray, time_s: FloatArray) -> None:
    """Refuse a column with NaN or infinite values.

    Raises:
        RecordingError: with their number and the first row and time.
    """
    if np.isfinite(values).all():
        return
    bad = np.flatnonzero(~np.isfinite(values))
    where = "" if name == TIME else f" (time {time_s[bad[0]]:.9g} s)"
    raise RecordingError(
        f"column {name!r} has {len(bad)} NaN or infinite values of {len(values)}, "
        f"the first at row {bad[0]}{where}; "
        "remove those rows (they become a hole in the time axis) or leave the column out"
    )
