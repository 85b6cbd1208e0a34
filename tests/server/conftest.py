"""Recordings and campaign files for the tests of services and command line."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from daq.recording.recording import recording_from_columns
from daq.recording.store import write_recording
from tests.server.postgres import REASON, Cluster, find_programs, private_cluster

REPOSITORY = Path(__file__).resolve().parents[2]
GAIN, TIME_CONSTANT_S = 1.1, 0.55
RecordingMaker = Callable[..., Path]


def joint_signals(seed: int, n: int, sample_time_s: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return time, current and speed of a first-order joint, exact for a current held over each sample."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(n) * sample_time_s
    current = sum(
        0.2 * np.sin(2 * np.pi * (k * time_s / 20.0 + rng.random())) for k in (1, 2, 3, 5, 8, 13, 21)
    )
    pole = np.exp(-sample_time_s / TIME_CONSTANT_S)
    speed = np.zeros(n)
    for k in range(1, n):
        speed[k] = pole * speed[k - 1] + GAIN * (1.0 - pole) * current[k - 1]
    return time_s, np.asarray(current), speed + 1e-4 * rng.standard_normal(n)


@pytest.fixture(scope="session")
def postgres() -> Iterator[Cluster]:
    """Give a PostgreSQL server of our own, shared by all tests; skips where it is not installed."""
    programs = find_programs()
    if programs is None:
        pytest.skip(REASON)
    with private_cluster(programs) as cluster:
        yield cluster


@pytest.fixture
def make_recording(tmp_path: Path) -> RecordingMaker:
    """Return a function that writes a recording of a joint, with columns replaced or left out."""

    def make(name: str, seed: int = 1, n: int = 6000, **columns: np.ndarray | None) -> Path:
        time_s, current, speed = joint_signals(seed, n, 0.01)
        all_columns = {"time_s": time_s, "current_A": current, "speed_rad_s": speed, **columns}
        given = {key: values for key, values in all_columns.items() if values is not None}
        recording = recording_from_columns(given, sample_time_s=0.01)
        return write_recording(recording, tmp_path / f"{name}.parquet")

    return make


@pytest.fixture
def campaign_file(tmp_path: Path) -> Callable[[str], Path]:
    """Return a function that writes a campaign file of the given steps for the emulated rig."""

    def make(steps: str) -> Path:
        path = tmp_path / "campaign.yaml"
        rig = REPOSITORY / "config" / "rigs" / "emulated.yaml"
        path.write_text(f"name: trial\nrig: {rig}\nsteps:\n{steps}", encoding="utf-8")
        return path

    return make
