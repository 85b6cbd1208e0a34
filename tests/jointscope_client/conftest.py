"""The client against the real service, which the client's own pytest plugin starts."""

from pathlib import Path

import pytest

from jointscope_client.emulated_service import EmulatedRig
from jointscope_client.records import RecordingInfo
from tests.server.service.measured import as_csv, measured_columns


@pytest.fixture
def measured_file(tmp_path: Path) -> Path:
    """Return a measured CSV file."""
    path = tmp_path / "measured.csv"
    path.write_bytes(as_csv(measured_columns()))
    return path


@pytest.fixture
def uploaded(emulated_rig: EmulatedRig, measured_file: Path) -> RecordingInfo:
    """Return a recording made of it."""
    return emulated_rig.client.recordings.upload(measured_file)
