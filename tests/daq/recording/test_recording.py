"""The recording as a data structure: lazy, read-only, and clear about what it lacks."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from daq.errors import RecordingError
from daq.recording.checks import require_columns
from daq.recording.derived_speed import with_speed
from daq.recording.recording import GapSpan, LazyColumns, Recording, cut, recording_from_columns
from daq.recording.store import read_recording, write_recording


def sine_recording(**columns: np.ndarray[tuple[int], np.dtype[np.float64]]) -> Recording:
    time_s = np.arange(1000) * 0.001
    gap = GapSpan(row=600, start_s=0.6, missing_samples=0, cause="reboot")
    given = {"time_s": time_s, "position_m": np.sin(time_s), **columns}
    return recording_from_columns(given, sample_time_s=0.001, gaps=(gap,), metadata={"operator": "Ada"})


def test_columns_are_loaded_once_and_only_when_asked_for() -> None:
    loaded: list[str] = []

    def load() -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        loaded.append("current_A")
        return np.zeros(3)

    columns = LazyColumns({"current_A": load})
    assert "current_A" in columns
    assert not loaded
    assert columns["current_A"] is columns["current_A"]
    assert loaded == ["current_A"]


def test_columns_cannot_be_written_to() -> None:
    with pytest.raises(ValueError, match="read-only"):
        sine_recording().column("position_m")[0] = 1.0


def test_arrays_given_stay_the_callers_own() -> None:
    current = np.zeros(1000)
    recording = sine_recording(current_A=current)
    current[0] = 9.0
    assert recording.column("current_A")[0] == 0.0


def test_missing_column_is_named_with_those_there_are() -> None:
    with pytest.raises(
        RecordingError, match=r"'current_A' is missing; .* time_s, position_m\. .*--map current_A="
    ):
        sine_recording().column("current_A")


def test_column_without_unit_is_refused() -> None:
    with pytest.raises(RecordingError, match="columns without a unit: voltage"):
        sine_recording(voltage=np.zeros(1000))


def test_column_of_another_length_is_refused() -> None:
    with pytest.raises(RecordingError, match=r"'current_A' has shape \(5,\); time_s has 1000 samples"):
        sine_recording(current_A=np.zeros(5))


def test_nan_is_refused_with_number_row_and_time() -> None:
    current = np.zeros(1000)
    current[[17, 40]] = np.nan
    with pytest.raises(
        RecordingError, match=r"'current_A' has 2 NaN .* of 1000, the first at row 17 \(time 0.017 s\)"
    ):
        require_columns(sine_recording(current_A=current), ["current_A"])


def test_unit_that_contradicts_the_name_is_refused() -> None:
    recording = recording_from_columns(
        {"time_s": [0.0, 0.1], "current_A": [1.0, 2.0]}, sample_time_s=0.1, units={"current_A": "mA"}
    )
    with pytest.raises(RecordingError, match=r"'current_A' is stated in 'mA' but its name says 'A'.*\[mA\]"):
        require_columns(recording, ["current_A"])


def test_recording_survives_writing_and_reading(tmp_path: Path) -> None:
    recording = sine_recording(current_A=np.random.default_rng(1).normal(size=1000))
    again = read_recording(write_recording(recording, tmp_path / "a.parquet"))
    assert {name: again.column(name).tolist() for name in again.columns} == {
        name: recording.column(name).tolist() for name in recording.columns
    }
    assert again.gaps == recording.gaps
    assert again.units == recording.units
    assert again.metadata["operator"] == "Ada"


def test_parquet_of_others_is_not_taken_for_ours(tmp_path: Path) -> None:
    pq.write_table(pa.table({"time_s": [0.0, 0.1]}), tmp_path / "a.parquet")
    with pytest.raises(
        RecordingError, match="no recording of Jointscope; bring it in by `jointscope import`"
    ):
        read_recording(tmp_path / "a.parquet")


@pytest.mark.parametrize("content", [None, b"", b"PAR1 and then nothing"])
def test_file_that_cannot_be_read_is_named(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "a.parquet"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(RecordingError, match=r"cannot read recording .*a\.parquet"):
        read_recording(path)


def test_cut_keeps_the_time_axis_and_moves_the_gap() -> None:
    part = cut(sine_recording(), 0.5, 0.7)
    assert (part.n, part.time_s[0], part.gaps[0].row) == (200, 0.5, 100)


def test_cut_outside_the_recording_is_refused() -> None:
    with pytest.raises(
        RecordingError, match="no sample between 5 s and 6 s; the recording covers 0 s to 0.999 s"
    ):
        cut(sine_recording(), 5.0, 6.0)


def test_speed_of_a_linear_axis_is_derived_and_described() -> None:
    recording = with_speed(sine_recording())
    assert recording.units["speed_m_s"] == "m/s"
    assert np.allclose(recording.column("speed_m_s"), np.cos(recording.time_s), atol=1e-3)
    assert recording.metadata["speed"]["derived_from"] == "position_m"


def test_speed_needs_a_uniform_time_base() -> None:
    time_s = np.cumsum(np.random.default_rng(2).uniform(0.8, 1.2, size=500)) * 0.01
    recording = recording_from_columns({"time_s": time_s, "position_rad": time_s}, sample_time_s=0.01)
    with pytest.raises(
        RecordingError, match="uniform time base, this one has .*jitter .*; resample it first"
    ):
        with_speed(recording)
