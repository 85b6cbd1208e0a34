"""Time axes that jitter, have holes, or are none."""

import numpy as np
import numpy.typing as npt
import pytest

from daq.errors import RecordingError
from daq.recording.recording import Recording, recording_from_columns
from daq.recording.timebase import analyse_time_base, resample_recording, to_uniform


def recorded(time_s: npt.NDArray[np.float64]) -> Recording:
    report = analyse_time_base(time_s)
    columns = {"time_s": time_s, "speed_rad_s": np.sin(2 * np.pi * 0.5 * time_s)}
    return recording_from_columns(columns, sample_time_s=report.sample_time_s, gaps=report.holes)


def test_regular_time_base_is_uniform() -> None:
    report = analyse_time_base(np.arange(1000.0) * 0.001)
    assert report.uniform
    assert report.sample_time_s == 0.001
    assert report.describe() == "sample time 1 ms, uniform, no holes"


def test_one_lost_sample_of_a_regular_time_base_is_a_hole() -> None:
    report = analyse_time_base(np.delete(np.arange(1000) * 0.001, 400))
    (hole,) = report.holes
    assert report.uniform
    assert (hole.row, hole.missing_samples) == (400, 1)
    assert hole.start_s == pytest.approx(0.4)


def test_alternating_periods_are_jitter_and_not_holes() -> None:
    steps = np.where(np.arange(999) % 3 == 0, 0.012, 0.010)
    report = analyse_time_base(np.concatenate([[0.0], np.cumsum(steps)]))
    assert not report.holes
    assert not report.uniform
    assert report.jitter_max_s == pytest.approx(0.002)


@pytest.mark.parametrize(
    ("time_s", "message"),
    [
        ([0.0], "has 1 samples; at least 2"),
        (
            [0.0, 0.1, 0.05, 0.2],
            "backwards or stands still at 1 places, first at row 2: 0.05 s follows 0.1 s",
        ),
        ([0.0, 0.1, 0.1], "first at row 2"),
        ([0.0, np.nan, 0.2], "1 values that are no finite numbers, the first at row 1"),
    ],
)
def test_impossible_time_axis_is_refused(time_s: list[float], message: str) -> None:
    with pytest.raises(RecordingError, match=message):
        analyse_time_base(np.array(time_s))


def test_jittered_samples_land_on_a_uniform_grid() -> None:
    steps = np.random.default_rng(1).uniform(0.004, 0.006, size=2000)
    uniform = to_uniform(recorded(np.concatenate([[0.0], np.cumsum(steps)])), 0.005)
    assert np.allclose(np.diff(uniform.time_s), 0.005)
    # (w T)^2 / 8 with w = pi rad/s and T = 6 ms.
    assert np.abs(uniform.column("speed_rad_s") - np.sin(np.pi * uniform.time_s)).max() < 4.5e-5


def test_grid_does_not_bridge_a_hole() -> None:
    time_s = np.concatenate([np.arange(100), np.arange(140, 240)]) * 0.01
    uniform = to_uniform(recorded(time_s), 0.01)
    (gap,) = uniform.gaps
    assert (gap.row, gap.missing_samples) == (100, 40)
    assert np.allclose(uniform.time_s, time_s)


def test_run_shorter_than_a_step_becomes_part_of_the_hole() -> None:
    time_s = np.concatenate([np.arange(100), [120], np.arange(140, 240)]) * 0.01
    uniform = to_uniform(recorded(time_s), 0.01)
    assert uniform.n == 200
    assert [gap.missing_samples for gap in uniform.gaps] == [40]


def test_whole_factor_is_decimated_without_interpolation() -> None:
    resampled = resample_recording(recorded(np.arange(2000.0) * 0.01), 0.2)
    assert "regridded" not in resampled.metadata
    assert resampled.metadata["decimation"]["factor"] == 20


def test_jittering_record_reaches_the_sample_time_asked_for() -> None:
    steps = np.random.default_rng(2).uniform(0.009, 0.0125, size=4000)
    resampled = resample_recording(recorded(np.concatenate([[0.0], np.cumsum(steps)])), 0.2)
    assert np.allclose(np.diff(resampled.time_s), 0.2)
    inside = slice(20, -20)
    error = resampled.column("speed_rad_s")[inside] - np.sin(np.pi * resampled.time_s[inside])
    # 2e-4 of straight lines between samples, 4e-4 of the filter's pass band.
    assert np.abs(error).max() < 1e-3


def test_shorter_sample_time_than_recorded_is_refused() -> None:
    with pytest.raises(RecordingError, match=r"sample time 0.005 s is shorter than the recording's 0.01 s"):
        resample_recording(recorded(np.arange(200.0) * 0.01), 0.005)
