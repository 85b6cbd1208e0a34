"""A recording as the fits see it: input, outputs, angle, windows, at full rate and averaged into bins.

Averaging input and output over the same bins keeps their timing and takes most of the noise away; the simulation then
needs fewer steps. Bins never reach across a hole.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from daq.recording.recording import Recording
from discrepancy.data.clean import MIN_SAMPLES, check_share, check_time, find_holes, find_outliers, repair
from discrepancy.errors import GapInputError
from discrepancy.model.schema import JointModel

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

SPEED, POSITION, CURRENT, TORQUE = range(4)


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """One output to reproduce.

    Attributes:
        row: row of the simulation's output (SPEED, POSITION or CURRENT).
        values: measured, shape (n,).
        weight: 1 where the sample counts, 0 where it is no measurement, shape (n,).
    """

    name: str
    row: int
    values: FloatArray
    weight: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Series:
    """One record.

    Attributes:
        step: nominal sample time, s.
        original_step: sample time before binning, s.
        input, angle, speed: shape (n,); angle and speed may be empty.
        windows: first rows, `-k - 1` for a fresh start at row k.
        starts: speed and angle there, shape (m, 2).
    """

    label: str
    step: float
    original_step: float
    time_s: FloatArray
    input: FloatArray
    angle: FloatArray
    channels: tuple[Channel, ...]
    windows: IntArray
    starts: FloatArray
    outliers: int = 0

    @property
    def n(self) -> int:
        """Number of samples."""
        return int(self.time_s.size)

    @property
    def factor(self) -> int:
        """Number of recorded samples that one of these averages."""
        return round(self.step / self.original_step)

    @property
    def edges(self) -> list[tuple[int, int]]:
        """First and last-but-one row of each window."""
        first = [int(k if k >= 0 else -k - 1) for k in self.windows]
        return list(zip(first, [*first[1:], self.n], strict=True))


def channel_row(name: str) -> int:
    """Return the simulation's output row that a column stands for."""
    for prefix, row in (("speed", SPEED), ("velocity", SPEED), ("position", POSITION), ("current", CURRENT)):
        if name.startswith(prefix):
            return row
    raise GapInputError(
        f"output {name!r}: only columns that begin with speed, position or current can be reproduced"
    )


def angle_column(recording: Recording, model: JointModel) -> str | None:
    """Return the measured position column, if there is one."""
    wanted = "position_m" if model.is_linear_axis else "position_rad"
    return wanted if wanted in recording.columns else None


def check_columns(recording: Recording, model: JointModel, label: str) -> set[str]:
    """Return the recording's columns.

    Raises:
        GapInputError: a column that the model names is missing.
    """
    names = set(recording.columns)
    for name in (model.input, *model.outputs):
        if name not in names:
            raise GapInputError(
                f"{label}: column {name!r} of model {model.name!r} is missing; "
                f"the recording has {', '.join(sorted(names))}"
            )
    return names


def read_series(recording: Recording, model: JointModel, label: str, least: int = MIN_SAMPLES) -> Series:
    """Take from a recording what the model needs.

    Args:
        recording: measured columns.
        model: names the columns.
        label: what messages call the recording.
        least: samples that the purpose needs.

    Raises:
        GapInputError: a column is missing or the time axis is broken.
    """
    names = check_columns(recording, model, label)
    time = np.array(recording.columns["time_s"], dtype=np.float64)
    step = check_time(time, label, least)
    time = time - time[0]
    raw = np.asarray(recording.columns[model.input], dtype=np.float64)
    bad = find_outliers(raw)
    check_share(bad, label, model.input)
    outputs = list(model.outputs)
    if model.input == "current_ref_A" and "current_A" in names and "current_A" not in outputs:
        outputs.append("current_A")
    channels = []
    for name in outputs:
        values = np.asarray(recording.columns[name], dtype=np.float64)
        wrong = find_outliers(values)
        check_share(wrong, label, name)
        channels.append(
            Channel(
                name=name,
                row=channel_row(name),
                values=repair(time, values, wrong),
                weight=(~wrong).astype(np.float64),
            )
        )
    series = Series(
        label=label,
        step=step,
        original_step=step,
        time_s=time,
        input=repair(time, raw, bad),
        angle=_angle(recording, model, time, channels),
        channels=tuple(channels),
        windows=np.array([-1, *(-find_holes(time, step) - 1)], dtype=np.int64),
        starts=np.zeros((1, 2)),
        outliers=int(bad.sum() + sum((c.weight == 0.0).sum() for c in channels)),
    )
    return with_starts(series)


def _angle(recording: Recording, model: JointModel, time: FloatArray, channels: list[Channel]) -> FloatArray:
    """Return the measured angle, or the integral of the measured speed."""
    name = angle_column(recording, model)
    if name is not None:
        values = np.asarray(recording.columns[name], dtype=np.float64)
        return repair(time, values, find_outliers(values))
    for channel in channels:
        if channel.row == SPEED:
            mean = 0.5 * (channel.values[1:] + channel.values[:-1])
            return np.concatenate([[0.0], np.cumsum(mean * np.diff(time))])
    return np.empty(0)


def with_starts(series: Series) -> Series:
    """Set each window's starting speed and angle from the measured samples around its beginning."""
    starts = np.zeros((len(series.windows), 2))
    by_row = {channel.row: channel for channel in series.channels}
    for m, (a, b) in enumerate(series.edges):
        few = slice(a, min(b, a + max(3, int(0.01 / series.step))))
        time = series.time_s[few] - series.time_s[a]
        if SPEED in by_row:
            starts[m, 0] = float(np.mean(by_row[SPEED].values[few]))
        elif POSITION in by_row and time.size > 2:
            starts[m, 0] = float(np.polyfit(time, by_row[POSITION].values[few], 1)[0])
        if POSITION in by_row:
            starts[m, 1] = float(by_row[POSITION].values[a])
        elif series.angle.size:
            starts[m, 1] = float(series.angle[a])
    return replace(series, starts=starts)


def bin_index(series: Series, factor: int) -> tuple[IntArray, list[int]]:
    """Return which samples make up each bin, shape (bins, factor), and which windows are long enough to have any."""
    rows, kept = [], []
    for m, (a, b) in enumerate(series.edges):
        full = (b - a) // factor
        if full < 2:
            continue
        rows.append(np.arange(a, a + full * factor, dtype=np.int64).reshape(full, factor))
        kept.append(m)
    return np.concatenate(rows), kept


def bin_series(series: Series, factor: int) -> Series:
    """Average `factor` neighbouring samples; windows begin where they began."""
    if factor <= 1:
        return series
    index, kept = bin_index(series, factor)
    edges = series.edges
    counts = [(edges[m][1] - edges[m][0]) // factor for m in kept]
    firsts = [-int(k) - 1 for k in np.cumsum([0, *counts[:-1]])]

    def mean(values: FloatArray) -> FloatArray:
        return np.asarray(values[index].mean(axis=1))

    channels = []
    for channel in series.channels:
        weight = channel.weight[index]
        total = weight.sum(axis=1)
        values = (channel.values[index] * weight).sum(axis=1) / np.maximum(total, 1.0)
        values = np.where(total > 0, values, mean(channel.values))
        channels.append(replace(channel, values=values, weight=np.sqrt(total / factor)))
    return with_starts(
        replace(
            series,
            step=series.step * factor,
            time_s=mean(series.time_s),
            input=mean(series.input),
            angle=mean(series.angle) if series.angle.size else series.angle,
            channels=tuple(channels),
            windows=np.array(firsts, dtype=np.int64),
        )
    )


def cut_windows(series: Series, length_s: float) -> Series:
    """Cut each window into shorter ones whose outer states are set anew (multiple shooting)."""
    rows: list[int] = []
    every = max(8, round(length_s / series.step))
    for a, b in series.edges:
        rows.append(-a - 1)
        rows.extend(range(a + every, b - every // 2, every))
    return with_starts(replace(series, windows=np.array(rows, dtype=np.int64)))
