"""From a recording to the estimators' data: columns, holes, NaN, derived speed, the input between samples."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from daq.recording.recording import recording_from_columns
from daq.recording.store import write_recording
from server.errors import InputError
from server.services.dataset import Signals, driven_span, prepare_data

RecordingMaker = Callable[..., Path]
PLAIN = Signals()


def first_order_theta(u: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Return pole and input weight of y(k) = pole y(k-1) + weight u(k-1) by least squares."""
    solution = np.linalg.lstsq(np.column_stack([y[:-1], u[:-1]]), y[1:], rcond=None)[0]
    return float(solution[0]), float(solution[1])


def test_decimated_data_hold_pole_and_gain_of_the_joint(make_recording: RecordingMaker) -> None:
    data = prepare_data(make_recording("joint", n=20_000), PLAIN, 0.2).dataset
    pole, weight = first_order_theta(data.u[20:-20], data.y[20:-20])
    # The joint of conftest: 0.55 s, gain 1.1. Without the mean over each interval the pole is 0.04 off.
    assert pole == pytest.approx(math.exp(-0.2 / 0.55), abs=0.004)
    assert weight / (1.0 - pole) == pytest.approx(1.1, rel=0.005)


def test_data_at_their_own_sample_time_are_used_as_they_are(make_recording: RecordingMaker) -> None:
    data = prepare_data(make_recording("joint", n=500), PLAIN, 0.01)
    pole, _ = first_order_theta(data.dataset.u, data.dataset.y)
    assert data.dataset.n == 500
    assert pole == pytest.approx(math.exp(-0.01 / 0.55), abs=1e-3)
    assert not any("averaged" in note for note in data.notes)


def test_the_reference_is_the_input_where_it_was_recorded(make_recording: RecordingMaker) -> None:
    path = make_recording("joint", n=500, current_ref_A=np.zeros(500))
    assert prepare_data(path, PLAIN, 0.01).input == ("current_ref_A", "A")


def test_a_missing_speed_is_derived_from_the_position(make_recording: RecordingMaker) -> None:
    time_s = np.arange(6000) * 0.01
    position = np.sin(2 * np.pi * 0.2 * time_s)
    path = make_recording("joint", speed_rad_s=None, position_rad=position)
    data = prepare_data(path, PLAIN, 0.1)
    true_speed = 2 * np.pi * 0.2 * np.cos(2 * np.pi * 0.2 * data.time_s)
    assert data.dataset.y[20:-20] == pytest.approx(true_speed[20:-20], abs=0.01)
    assert any("speed_rad_s derived from position_rad" in note for note in data.notes)


def test_a_time_base_that_jitters_is_put_on_a_grid(make_recording: RecordingMaker) -> None:
    time_s = np.arange(4000) * 0.01 + np.random.default_rng(3).uniform(-0.003, 0.003, 4000)
    path = make_recording("joint", n=4000, time_s=time_s - time_s[0], speed_rad_s=np.sin(time_s))
    data = prepare_data(path, PLAIN, 0.1)
    assert data.dataset.y[10:-10] == pytest.approx(np.sin(data.time_s + time_s[0])[10:-10], abs=0.005)
    assert "jitter" in data.notes[0]


def test_a_hole_becomes_the_border_of_two_segments(tmp_path: Path) -> None:
    time_s = np.concatenate([np.arange(1000), np.arange(1500, 3000)]) * 0.01
    columns = {"time_s": time_s, "current_A": np.cos(time_s), "speed_rad_s": np.sin(time_s)}
    path = tmp_path / "hole.csv"
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="")
    data = prepare_data(path, PLAIN, 0.1)
    assert data.dataset.starts == (0, 100)
    assert data.time_s[100] == pytest.approx(15.0)


def test_samples_outside_the_excitation_are_left_out(tmp_path: Path) -> None:
    n = 3000
    time_s = np.arange(n) * 0.01
    metadata = {
        "first_tick": 1000,
        "tick_hz": 2500,
        "duration_s": 20.0,
        "notes": [{"kind": "outcome", "start_tick": 1000 + 2500}],
    }
    columns = {"time_s": time_s, "current_A": np.cos(time_s), "speed_rad_s": np.sin(time_s)}
    recording = recording_from_columns(columns, sample_time_s=0.01, metadata=metadata)
    assert driven_span(recording) == (1.0, 21.0)
    data = prepare_data(write_recording(recording, tmp_path / "run.parquet"), PLAIN, 0.1)
    assert data.time_s[0] == pytest.approx(1.0)
    assert data.dataset.n == 200


@pytest.mark.parametrize(
    ("columns", "signals", "message"),
    [
        (
            {"current_A": None},
            PLAIN,
            "there is no current_ref_A or current_A to take as the input; choose one",
        ),
        ({"speed_rad_s": None}, PLAIN, "'speed_rad_s' is missing and no position_rad to derive it from"),
        ({}, Signals(input="motor_force_N"), "column 'motor_force_N' is missing; this recording has time_s"),
        ({}, Signals(output="speed_m_s"), "'speed_m_s' is missing and no position_m to derive it from"),
        (
            {},
            Signals(output="torque_Nm"),
            "output column 'torque_Nm' is missing; choose one with --output: cur",
        ),
    ],
)
def test_a_column_that_is_missing_is_named(
    make_recording: RecordingMaker, columns: dict[str, None], signals: Signals, message: str
) -> None:
    path = make_recording("joint", n=500, **columns)
    with pytest.raises(InputError) as caught:
        prepare_data(path, signals, 0.1)
    assert message in str(caught.value)
    assert str(path) in str(caught.value)


def test_nan_in_a_recording_is_refused_with_its_place(make_recording: RecordingMaker) -> None:
    speed = np.zeros(500)
    speed[[7, 9]] = np.nan
    path = make_recording("joint", n=500, speed_rad_s=speed)
    with pytest.raises(
        InputError, match=r"'speed_rad_s' has 2 NaN or infinite values of 500, the first at row 7"
    ):
        prepare_data(path, PLAIN, 0.1)


def test_nan_in_a_column_that_is_not_used_does_no_harm(make_recording: RecordingMaker) -> None:
    path = make_recording("joint", n=500, position_rad=np.full(500, np.nan))
    assert prepare_data(path, PLAIN, 0.1).dataset.n == 50


def test_a_sample_time_below_the_recordings_own_is_refused(make_recording: RecordingMaker) -> None:
    with pytest.raises(InputError, match=r"sample time 0.001 s is shorter than the recording's 0.01 s"):
        prepare_data(make_recording("joint", n=500), PLAIN, 0.001)
