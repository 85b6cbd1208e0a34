"""Import of measured files that nobody here made; skipped where they are not at hand."""

import os
from pathlib import Path

import numpy as np
import pytest

from daq.exchange.importing import import_file
from daq.exchange.mapping import parse_mappings
from daq.recording.derived_speed import with_speed
from daq.recording.timebase import analyse_time_base, resample_recording
from daq.speed.options import SpeedOptions

_BESIDE = Path(__file__).parents[3].parent / "shared" / "data"


@pytest.fixture
def measured() -> Path:
    folder = Path(os.environ.get("JOINTSCOPE_SHARED_DATA", _BESIDE))
    if not (folder / "emps").is_dir():
        pytest.skip(
            f"no measured data at {folder}; set JOINTSCOPE_SHARED_DATA to the folder that holds emps/"
        )
    return folder


def test_emps_is_uniform_and_its_speed_follows_from_position(measured: Path) -> None:
    recording = import_file(measured / "emps" / "emps_train.csv.gz")
    assert recording.n == 24841
    assert analyse_time_base(recording.time_s).describe() == "sample time 1 ms, uniform, no holes"
    speed = with_speed(recording, SpeedOptions(bandwidth_hz=20.0)).column("speed_m_s")
    travelled = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))]) * 0.001
    # The axis moves 0.24 m; integrating the speed finds it again to within 0.1 mm.
    assert (
        np.abs(travelled - (recording.column("position_m") - recording.column("position_m")[0])).max() < 1e-4
    )


def test_emps_voltage_maps_to_the_published_force(measured: Path) -> None:
    path = measured / "emps" / "emps_train.csv.gz"
    mapped = import_file(
        path, parse_mappings(["motor_force_N=motor_voltage_V*35.15065"]), leave_out=["motor_force_N"]
    )
    assert np.allclose(
        mapped.column("motor_force_N"), import_file(path).column("motor_force_N"), rtol=1e-6, atol=1e-6
    )


def test_ur10e_alternates_between_two_periods(measured: Path) -> None:
    recording = import_file(measured / "ur10e" / "ur10e_joint1.csv")
    report = analyse_time_base(recording.time_s)
    assert (report.sample_time_s, report.uniform, report.holes) == (0.01, False, ())
    assert report.jitter_max_s == pytest.approx(0.002)
    resampled = resample_recording(recording, 0.2)
    assert np.allclose(np.diff(resampled.time_s), 0.2)
    # The time base alone decides the scale: the speed integrates to the position.
    speed, position = (recording.column(name) for name in ("speed_rad_s", "position_rad"))
    steps = np.diff(recording.time_s) * 0.5 * (speed[1:] + speed[:-1])
    assert np.corrcoef(np.cumsum(steps), position[1:])[0, 1] > 0.999


def test_xl330_time_stamps_are_irregular_and_begin_at_zero(measured: Path) -> None:
    recording = import_file(measured / "xl330_pendulum" / "xl330_m0.49_l0.1_kp400_sin_sin.csv")
    report = analyse_time_base(recording.time_s)
    assert recording.time_s[0] == 0.0
    assert not report.uniform
    assert report.jitter_rms_s == pytest.approx(1.5e-4, rel=0.05)
    assert resample_recording(recording, 0.02).sample_time_s == pytest.approx(0.02)
