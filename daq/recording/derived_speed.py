"""The speed column of a recording that has none: from position, without delay, run by run between holes."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from daq.errors import RecordingError
from daq.recording.recording import FloatArray, LazyColumns, Recording
from daq.recording.timebase import analyse_time_base
from daq.speed.filters import DEFAULT_OPTIONS, describe_zero_phase, speed_from_position_zero_phase
from daq.speed.options import SpeedMethod, SpeedOptions

# Position column -> speed column derived from it.
SPEED_OF: Final = {"position_rad": "speed_rad_s", "position_m": "speed_m_s"}


def derive_speed(
    position: FloatArray, segments: Sequence[slice], sample_time_s: float, options: SpeedOptions
) -> FloatArray:
    """Return the zero-phase speed of each run without holes, shape of `position`."""
    speed = np.empty(len(position))
    for run in segments:
        speed[run] = speed_from_position_zero_phase(position[run], sample_time_s, options)
    return speed


def speed_options(stored: Mapping[str, Any] | None) -> SpeedOptions:
    """Return the speed options that a header or a recording's metadata state; the default ones for None.

    Raises:
        RecordingError: the method is unknown.
    """
    if stored is None:
        return SpeedOptions()
    methods = [method.value for method in SpeedMethod]
    if stored["method"] not in methods:
        raise RecordingError(f"speed method {stored['method']!r} is unknown; there are {', '.join(methods)}")
    return SpeedOptions(method=SpeedMethod(stored["method"]), bandwidth_hz=float(stored["bandwidth_hz"]))


def describe_speed(position: str, sample_time_s: float, options: SpeedOptions) -> dict[str, float | str]:
    """State for a recording's metadata how its speed was derived."""
    return {**describe_zero_phase(sample_time_s, options).to_dict(), "derived_from": position}


def with_speed(recording: Recording, options: SpeedOptions = DEFAULT_OPTIONS) -> Recording:
    """Return the recording with a speed column derived from its position; replaces one that is there.

    Raises:
        RecordingError: no position column, or a time base that jitters.
    """
    position = next((name for name in SPEED_OF if name in recording.columns), None)
    if position is None:
        raise RecordingError(
            f"speed needs a column {' or '.join(SPEED_OF)}; there are {', '.join(recording.columns)}"
        )
    report = analyse_time_base(recording.time_s)
    if not report.uniform:
        raise RecordingError(
            f"speed needs a uniform time base, this one has {report.describe()}; resample it first"
        )
    name, sample_time_s = SPEED_OF[position], recording.sample_time_s
    segments = recording.segments()
    return Recording(
        columns=LazyColumns(
            {
                **recording.columns.loaders(),
                name: lambda: derive_speed(recording.column(position), segments, sample_time_s, options),
            }
        ),
        units={**recording.units, name: recording.units[position] + "/s"},
        gaps=recording.gaps,
        metadata={**recording.metadata, "speed": describe_speed(position, sample_time_s, options)},
        sample_time_s=sample_time_s,
        n=recording.n,
    )
