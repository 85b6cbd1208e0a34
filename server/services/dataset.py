"""From a recording on disk to input and output samples at the identification's sample time.

The way: read, choose the columns, refuse what cannot be used (missing column, NaN), put a time base that
jitters on a uniform grid, derive the speed where there is none, decimate input and output through the same
anti-alias filter, keep the holes as segment borders. Every step that changes the data leaves a sentence in
`notes`.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from daq.errors import RecordingError
from daq.recording.checks import require_columns
from daq.recording.derived_speed import SPEED_OF, with_speed
from daq.recording.kernels import average_ahead
from daq.recording.recording import TIME, FloatArray, LazyColumns, Recording, cut
from daq.recording.resample import describe_decimation
from daq.recording.timebase import analyse_time_base, resample_recording, to_uniform
from estimators.dataset import Dataset
from server.errors import InputError, InputLocation
from server.services.exchange import open_recording

INPUT_CHOICES = ("current_ref_A", "current_A")
POSITION_OF = {speed: position for position, speed in SPEED_OF.items()}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Signals:
    """Which columns are input and output; `input` None takes the first of `INPUT_CHOICES` that exists."""

    input: str | None = None
    output: str = "speed_rad_s"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PreparedData:
    """One recording made ready for the estimators.

    Attributes:
        dataset: input and output at the identification's sample time.
        time_s: time of each sample from the recording's first, shape (N,).
        source: the file it was read from.
        input: column and unit of the input.
        output: column and unit of the output.
        notes: what was done to the data, one sentence each.
        facts: the same as JSON values, with the recording's own time base.
    """

    dataset: Dataset
    time_s: FloatArray
    source: Path
    input: tuple[str, str]
    output: tuple[str, str]
    notes: tuple[str, ...]
    facts: dict[str, object]


def prepare_data(path: Path, signals: Signals, sample_time_s: float) -> PreparedData:
    """Read a recording and bring input and output to `sample_time_s`.

    Raises:
        InputError: unreadable file, missing column, NaN, or a sample time that the recording cannot give.
    """
    recording = open_recording(path)
    try:
        return _prepare(path, recording, signals, sample_time_s)
    except (RecordingError, ValueError) as error:
        raise InputError(str(error), InputLocation(source=path)) from error


def _prepare(path: Path, recording: Recording, signals: Signals, sample_time_s: float) -> PreparedData:
    input_name = signals.input or _default_input(recording)
    source = _output_source(recording, signals.output)
    require_columns(recording, (input_name, source))
    slim = _keep(recording, (input_name, source))
    base = analyse_time_base(slim.time_s)
    notes = [base.describe()]
    span = driven_span(recording)
    if span is not None:
        slim = cut(slim, *span)
        notes.append(f"cut to the excitation, {span[0]:.4g} s to {span[1]:.4g} s")
    if source != signals.output:
        if not base.uniform:
            slim = to_uniform(slim, base.mean_step_s)
            notes.append(f"put on a uniform grid of {base.mean_step_s * 1e3:.4g} ms by straight lines")
        slim = _keep(with_speed(slim), (input_name, signals.output))
        notes.append(f"{signals.output} derived from {source}, zero phase")
    if sample_time_s >= 1.5 * base.sample_time_s:
        slim = average_input(slim, input_name, sample_time_s)
        notes.append("input averaged over each interval")
    resampled = resample_recording(slim, sample_time_s)
    notes.append(_describe_resampling(base.sample_time_s, resampled))
    # A hole behind the last sample separates nothing.
    starts = (0, *(gap.row for gap in resampled.gaps if 0 < gap.row < resampled.n))
    return PreparedData(
        dataset=Dataset(
            u=resampled.column(input_name),
            y=resampled.column(signals.output),
            sample_time_s=resampled.sample_time_s,
            starts=starts,
        ),
        time_s=np.asarray(resampled.time_s),
        source=path,
        input=(input_name, resampled.units[input_name]),
        output=(signals.output, resampled.units[signals.output]),
        notes=tuple(notes),
        facts={"time_base": base.to_dict(), "segments": len(starts), "samples": resampled.n, "notes": notes},
    )


def average_input(recording: Recording, input_name: str, sample_time_s: float) -> Recording:
    """Replace the input by its mean over the new sample time ahead, so that u(k) stands for k to k+1.

    The models, and their conversion to continuous time, take the input as held between samples. A decimated
    input is not: it moves between them, y(k) then answers to u(k) itself, which a model with a delay of one
    sample cannot say, and it fits a pole near or beyond -1 instead. An input that is held at its mean over
    each interval moves the joint almost as the real one does. A recording that is not decimated is left as it
    is: its input may well have been held.
    """
    time_s, values = recording.time_s, recording.column(input_name)
    means = np.empty(recording.n)
    for run in recording.segments():
        average_ahead(time_s[run], values[run], sample_time_s, means[run])
    return replace(recording, columns=LazyColumns({**recording.columns.loaders(), input_name: lambda: means}))


def driven_span(recording: Recording) -> tuple[float, float] | None:
    """Return from when to when the excitation played, on the recording's time axis; None where unknown.

    A recording of ours begins before the excitation and ends after the drive was switched off.
    """
    metadata = recording.metadata
    runs = [note for note in metadata.get("notes", ()) if note.get("kind") == "outcome"]
    if not runs or "first_tick" not in metadata or "duration_s" not in metadata:
        return None
    start_s = (runs[-1]["start_tick"] - metadata["first_tick"]) / metadata["tick_hz"]
    return start_s, start_s + float(metadata["duration_s"])


def _default_input(recording: Recording) -> str:
    for name in INPUT_CHOICES:
        if name in recording.columns:
            return name
    raise RecordingError(
        f"there is no {' or '.join(INPUT_CHOICES)} to take as the input; "
        f"choose one with --input: {_others(recording)}"
    )


def _output_source(recording: Recording, output: str) -> str:
    """Return the column that gives the output: itself, or the position that it is the speed of."""
    position = POSITION_OF.get(output, "")
    if output in recording.columns or position not in recording.columns:
        if output not in recording.columns:
            derived = f" and no {position} to derive it from" if position else ""
            raise RecordingError(
                f"output column {output!r} is missing{derived}; "
                f"choose one with --output: {_others(recording)}"
            )
        return output
    return position


def _others(recording: Recording) -> str:
    derived = [speed for position, speed in SPEED_OF.items() if position in recording.columns]
    return ", ".join(dict.fromkeys([name for name in recording.columns if name != TIME] + derived))


def _keep(recording: Recording, names: tuple[str, ...]) -> Recording:
    """Return a recording with time and these columns only, so that nothing else is decoded or filtered."""
    kept, loaders = dict.fromkeys((TIME, *names)), recording.columns.loaders()
    return replace(
        recording,
        columns=LazyColumns({name: loaders[name] for name in kept}),
        units={name: recording.units[name] for name in kept},
    )


def _describe_resampling(own_s: float, resampled: Recording) -> str:
    facts = resampled.metadata.get("decimation", {})
    factor = facts.get("factor", 1)
    holes = f", {len(resampled.gaps)} holes kept as segment borders" if resampled.gaps else ""
    if factor == 1:
        return f"used at {resampled.sample_time_s:g} s as they are ({resampled.n} samples{holes})"
    if "regridded" in resampled.metadata:
        own_s = float(resampled.metadata["regridded"]["sample_time_s"])
    stop = describe_decimation(factor, resampled.sample_time_s / factor)["stop_band_hz"]
    return (
        f"decimated from {own_s * 1e3:.4g} ms to {resampled.sample_time_s:g} s behind an anti-alias filter "
        f"({stop:.3g} Hz, linear phase, no delay): {resampled.n} samples{holes}"
    )
