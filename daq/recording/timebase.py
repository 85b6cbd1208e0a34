"""Time bases as they are: how much they jitter, where they have holes, and a uniform one made of them.

A hole is a step longer than 1.5 times the 95th percentile of all steps, so that a time base which alternates
between two periods (a loop that sometimes waits) counts as jitter, and a lost sample in a regular one as a
hole.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from daq.errors import RecordingError
from daq.recording.recording import TIME, FloatArray, GapSpan, Recording, recording_from_columns
from daq.recording.resample import decimate_recording

HOLE_CAUSE: Final = "hole"
# Steps that differ by less than this share of the sample time are one regular time base, written with few
# digits.
UNIFORM_TOLERANCE: Final = 0.01
# A time axis is no more exact than this.
_RESOLUTION_S: Final = 1e-12


@dataclass(frozen=True, slots=True, kw_only=True)
class TimeBaseReport:
    """What a time axis looks like.

    Attributes:
        sample_time_s: nominal time between samples: the median step.
        mean_step_s: mean of the steps that are no holes.
        jitter_rms_s: rms deviation of those steps from the nominal one.
        jitter_max_s: largest deviation of those steps.
        holes: the holes, in order.
        uniform: True where no step that is no hole deviates by more than 1 % of the nominal one.
    """

    sample_time_s: float
    mean_step_s: float
    jitter_rms_s: float
    jitter_max_s: float
    holes: tuple[GapSpan, ...]
    uniform: bool

    def to_dict(self) -> dict[str, float | int | bool]:
        """Return the figures as JSON values, for a recording's metadata."""
        return {
            "sample_time_s": self.sample_time_s,
            "mean_step_s": self.mean_step_s,
            "jitter_rms_s": self.jitter_rms_s,
            "jitter_max_s": self.jitter_max_s,
            "holes": len(self.holes),
            "missing_samples": sum(hole.missing_samples for hole in self.holes),
            "uniform": self.uniform,
        }

    def describe(self) -> str:
        """Return one sentence for people."""
        jitter = "uniform" if self.uniform else f"jitter {self.jitter_rms_s * 1e3:.3g} ms rms"
        missing = sum(hole.missing_samples for hole in self.holes)
        holes = f"{len(self.holes)} holes ({missing} samples)" if self.holes else "no holes"
        return f"sample time {self.sample_time_s * 1e3:.6g} ms, {jitter}, {holes}"


def analyse_time_base(time_s: FloatArray) -> TimeBaseReport:
    """Describe a time axis.

    Raises:
        RecordingError: fewer than two samples, a time that is not finite, or one that does not increase.
    """
    check_time(time_s)
    steps = np.diff(time_s)
    shortest, longest = float(steps.min()), float(steps.max())
    # Where all steps agree to rounding, any of them is the median; sorting millions would take longest here.
    typical = shortest if longest - shortest < _RESOLUTION_S else float(np.median(steps))
    nominal = round(typical, 12)
    # No step is a hole when the longest is within 1.5 times the shortest, whatever the quantile is.
    is_regular = longest <= 1.5 * shortest
    rows = np.flatnonzero(() if is_regular else steps > 1.5 * np.quantile(steps, 0.95)) + 1
    deviation = (np.delete(steps, rows - 1) if len(rows) else steps) - nominal
    holes = tuple(
        GapSpan(
            row=int(row),
            start_s=float(time_s[row - 1]) + nominal,
            missing_samples=max(1, round(float(steps[row - 1]) / nominal) - 1),
            cause=HOLE_CAUSE,
        )
        for row in rows
    )
    jitter_max = float(max(deviation.max(), -deviation.min()))
    return TimeBaseReport(
        sample_time_s=nominal,
        mean_step_s=nominal + float(deviation.mean()),
        jitter_rms_s=math.sqrt(deviation @ deviation / len(deviation)),
        jitter_max_s=jitter_max,
        holes=holes,
        uniform=jitter_max <= UNIFORM_TOLERANCE * nominal,
    )


def check_time(time_s: FloatArray) -> None:
    """Refuse a time axis that cannot be one.

    Raises:
        RecordingError: with the first row at fault and its values.
    """
    if len(time_s) < 2:
        raise RecordingError(f"{TIME} has {len(time_s)} samples; at least 2 are needed")
    if not np.isfinite(time_s).all():
        bad = np.flatnonzero(~np.isfinite(time_s))
        raise RecordingError(
            f"{TIME} has {len(bad)} values that are no finite numbers, the first at row {bad[0]}"
        )
    backwards = np.flatnonzero(np.diff(time_s) <= 0.0)
    if len(backwards):
        row = int(backwards[0]) + 1
        raise RecordingError(
            f"{TIME} runs backwards or stands still at {len(backwards)} places, first at row {row}: "
            f"{time_s[row]:.9g} s follows {time_s[row - 1]:.9g} s; sort the rows or drop the repeated ones"
        )


def to_uniform(recording: Recording, sample_time_s: float) -> Recording:
    """Put a recording that jitters on a uniform grid, by straight lines between its samples.

    Each run without holes gets its own grid from its first sample on. Straight lines err by at most (w T)^2 /
    8 of a motion at w rad/s sampled at T: 0.01 % for 1 Hz at 5 ms. Nothing is filtered: take a grid about as
    dense as the data and decimate afterwards (`resample_recording` does both).

    Returns:
        A recording in memory; runs too short for two grid points are left out and become part of the hole.
    """
    time = recording.time_s
    columns: dict[str, list[FloatArray]] = {name: [] for name in recording.columns}
    causes = {span.row: span.cause for span in recording.gaps}
    gaps: list[GapSpan] = []
    rows, last_s = 0, -math.inf
    for run in recording.segments():
        steps = math.floor((time[run.stop - 1] - time[run.start]) / sample_time_s + 1e-6)
        if steps < 1:
            continue
        grid = time[run.start] + np.arange(steps + 1) * sample_time_s
        if rows:
            gaps.append(_hole(rows, last_s, float(grid[0]), sample_time_s, causes.get(run.start, HOLE_CAUSE)))
        for name, pieces in columns.items():
            pieces.append(grid if name == TIME else np.interp(grid, time[run], recording.column(name)[run]))
        rows, last_s = rows + len(grid), float(grid[-1])
    if not rows:
        raise RecordingError(f"no run without holes is as long as one sample time of {sample_time_s:g} s")
    return recording_from_columns(
        {name: np.concatenate(pieces) for name, pieces in columns.items()},
        sample_time_s=sample_time_s,
        gaps=tuple(gaps),
        units=recording.units,
        metadata={**recording.metadata, "regridded": {"sample_time_s": sample_time_s, "method": "linear"}},
    )


def _hole(row: int, last_s: float, first_s: float, sample_time_s: float, cause: str) -> GapSpan:
    missing = max(1, round((first_s - last_s) / sample_time_s) - 1)
    return GapSpan(row=row, start_s=last_s + sample_time_s, missing_samples=missing, cause=cause)


def resample_recording(recording: Recording, sample_time_s: float) -> Recording:
    """Bring a recording to a longer, uniform sample time, whatever its own time base is.

    A time base that jitters, or whose sample time does not divide the wanted one, is first put on the densest
    grid that does, no finer than its own mean step; then every column goes through the same anti-alias
    filter.

    Raises:
        RecordingError: the wanted sample time is shorter than the recording's own.
    """
    report = analyse_time_base(recording.time_s)
    ratio = sample_time_s / report.sample_time_s
    if ratio < 1.0 - UNIFORM_TOLERANCE:
        raise RecordingError(
            f"sample time {sample_time_s:g} s is shorter than the recording's {report.sample_time_s:g} s; "
            f"ask for {report.sample_time_s:g} s or more"
        )
    if report.uniform and abs(ratio - round(ratio)) * report.sample_time_s < 1e-6 * sample_time_s:
        return decimate_recording(recording, round(ratio))
    factor = max(1, math.floor(sample_time_s / report.mean_step_s))
    return decimate_recording(to_uniform(recording, sample_time_s / factor), factor)
