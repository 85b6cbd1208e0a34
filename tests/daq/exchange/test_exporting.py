"""What is exported reads back as the same numbers, in every format."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from daq.errors import RecordingError
from daq.exchange.exporting import ExportFormat, export_recording, format_of
from daq.exchange.importing import import_file
from daq.recording.recording import GapSpan, Recording, recording_from_columns


@pytest.fixture
def recording() -> Recording:
    rng = np.random.default_rng(1)
    time_s = np.concatenate([np.arange(60), np.arange(70, 120)]) * 0.002
    columns = {
        "time_s": time_s,
        "current_A": rng.normal(size=110),
        "position_rad": rng.normal(size=110) / 3.0,
    }
    gap = GapSpan(row=60, start_s=0.12, missing_samples=10, cause="loss")
    return recording_from_columns(columns, sample_time_s=0.002, gaps=(gap,), metadata={"operator": "Ada"})


@pytest.mark.parametrize("file_name", ["a.csv", "a.mat", "a.parquet", "a.h5"])
def test_round_trip_through_our_own_import(recording: Recording, tmp_path: Path, file_name: str) -> None:
    path = tmp_path / file_name
    again = import_file(export_recording(recording, path, format_of(path)))
    assert set(again.columns) == set(recording.columns)
    for name in recording.columns:
        assert np.array_equal(again.column(name), recording.column(name)), name
    assert [(gap.row, gap.missing_samples) for gap in again.gaps] == [(60, 10)]


def test_csv_has_plain_names_and_gap_flags(recording: Recording, tmp_path: Path) -> None:
    text = export_recording(recording, tmp_path / "a.csv", ExportFormat.CSV).read_text().splitlines()
    assert text[0] == "time_s,current_A,position_rad,gap"
    assert [line.endswith(",1") for line in text[1:]] == recording.gap.tolist()


def test_hdf5_states_units_and_metadata(recording: Recording, tmp_path: Path) -> None:
    import h5py

    with h5py.File(export_recording(recording, tmp_path / "a.h5", ExportFormat.HDF5)) as file:
        assert file["current_A"].attrs["unit"] == "A"
        assert file["gap"][()].tolist() == recording.gap.tolist()
        assert json.loads(file["metadata"][()])["operator"] == "Ada"


def test_mat_states_units(recording: Recording, tmp_path: Path) -> None:
    from scipy.io import loadmat

    variables = loadmat(
        export_recording(recording, tmp_path / "a.mat", ExportFormat.MAT), simplify_cells=True
    )
    assert json.loads(variables["units"])["position_rad"] == "rad"


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # asammdf's own imports
def test_mdf4_round_trip(recording: Recording, tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf", reason="the extra jointscope[export] is not installed")
    with asammdf.MDF(export_recording(recording, tmp_path / "a.mf4", ExportFormat.MDF4)) as file:
        signal = file.get("current_A")
        assert np.array_equal(signal.samples, recording.column("current_A"))
        assert np.array_equal(signal.timestamps, recording.time_s)
        assert signal.unit == "A"


def test_mcap_round_trip(recording: Recording, tmp_path: Path) -> None:
    reader = pytest.importorskip("mcap.reader", reason="the extra jointscope[export] is not installed")
    with export_recording(recording, tmp_path / "a.mcap", ExportFormat.MCAP).open("rb") as file:
        messages = [
            (json.loads(message.data), message.log_time)
            for _, _, message in reader.make_reader(file).iter_messages()
        ]
    assert [content["current_A"] for content, _ in messages] == recording.column("current_A").tolist()
    assert [content["gap"] for content, _ in messages] == recording.gap.tolist()
    assert [log_time for _, log_time in messages] == np.rint(recording.time_s * 1e9).tolist()


@pytest.mark.parametrize(
    ("library", "export_format"), [("asammdf", ExportFormat.MDF4), ("mcap.writer", ExportFormat.MCAP)]
)
def test_missing_library_is_named_with_the_way_to_get_it(
    recording: Recording,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    library: str,
    export_format: ExportFormat,
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(RecordingError, match=r"needs the library .*pip install 'jointscope\[export\]'"):
        export_recording(recording, tmp_path / "a", export_format)


def test_folder_that_does_not_exist_is_named(recording: Recording, tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"cannot write .*nowhere"):
        export_recording(recording, tmp_path / "nowhere" / "a.csv", ExportFormat.CSV)


def test_unknown_ending_is_refused_with_those_known() -> None:
    with pytest.raises(RecordingError, match=r"one of \.csv, \.mat, \.parquet, \.h5, \.mf4, \.mcap"):
        format_of(Path("a.xlsx"))
