"""Files of others become recordings, or are refused with the place of the fault."""

import gzip
import hashlib
from pathlib import Path

import h5py
import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from scipy.io import savemat

from daq.errors import RecordingError
from daq.exchange.importing import import_file, load_recording
from daq.exchange.mapping import parse_mappings
from daq.recording.store import read_recording, write_recording

TIME_S = np.arange(50) * 0.01
CURRENT_MA = np.linspace(-1234.5, 1234.5, 50)


def write_csv(path: Path, separator: str = ",") -> None:
    rows = [
        f"t{separator}i",
        *(f"{t!r}{separator}{i!r}" for t, i in zip(TIME_S.tolist(), CURRENT_MA.tolist(), strict=True)),
    ]
    path.write_text("\n".join(rows) + "\n")


def write_gzip(path: Path) -> None:
    write_csv(path.with_suffix(".plain"))
    path.write_bytes(gzip.compress(path.with_suffix(".plain").read_bytes()))


def write_parquet(path: Path) -> None:
    pq.write_table(pa.table({"t": TIME_S, "i": CURRENT_MA, "remark": ["x"] * 50}), path)


def write_mat5(path: Path) -> None:
    savemat(path, {"run": {"t": TIME_S, "i": CURRENT_MA[:, None]}, "fs": 100.0})


def write_mat73(path: Path) -> None:
    with h5py.File(path, "w", userblock_size=512) as file:
        file["run/t"] = TIME_S[None, :]
        file["run/i"] = CURRENT_MA[None, :]
    header = b"MATLAB 7.3 MAT-file".ljust(116) + bytes(8) + b"\x00\x02IM"  # version 0x0200, little endian
    with path.open("r+b") as file:
        file.write(header)


@pytest.mark.parametrize(
    ("file_name", "write"),
    [
        ("run.csv", write_csv),
        ("run.csv.gz", write_gzip),
        ("run.parquet", write_parquet),
        ("run5.mat", write_mat5),
        ("run73.mat", write_mat73),
        ("run.h5", write_mat73),
    ],
)
def test_every_kind_gives_the_same_recording(tmp_path: Path, file_name: str, write: object) -> None:
    path = tmp_path / file_name
    write(path)  # type: ignore[operator]  # one of the functions above
    recording = import_file(path, parse_mappings(["time_s=t", "current_A=i*0.001"]))
    assert np.array_equal(recording.time_s, TIME_S)
    assert np.array_equal(recording.column("current_A"), CURRENT_MA * 0.001)
    assert recording.units == {"time_s": "s", "current_A": "A"}
    assert recording.sample_time_s == 0.01


def test_semicolons_are_recognised(tmp_path: Path) -> None:
    write_csv(tmp_path / "run.csv", ";")
    assert import_file(tmp_path / "run.csv", parse_mappings(["time_s=t", "current_A=i[mA]"])).n == 50


def test_imported_recording_is_stored_with_its_source(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    write_csv(path)
    recording = import_file(path, parse_mappings(["time_s=t", "current_A=i[mA]"]))
    metadata = read_recording(write_recording(recording, tmp_path / "run.parquet")).metadata
    assert metadata["source"]["file"] == "run.csv"
    assert metadata["source"]["sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
    assert metadata["source"]["mappings"][1] == {"name": "current_A", "source": "i", "factor": 0.001}
    assert metadata["time_base"]["uniform"]


def lines(tmp_path: Path, *rows: str) -> Path:
    path = tmp_path / "run.csv"
    path.write_text("\n".join(rows) + "\n")
    return path


def test_columns_with_our_names_need_no_mapping_and_others_are_listed(tmp_path: Path) -> None:
    recording = import_file(lines(tmp_path, "time_s,current_A,operator_mood", "0,1,3", "0.1,2,3"))
    assert list(recording.columns) == ["time_s", "current_A"]
    assert recording.metadata["source"]["left_out"] == ["operator_mood"]


def test_column_may_be_left_out(tmp_path: Path) -> None:
    path = lines(tmp_path, "time_s,current_A,position_rad", "0,1,nan", "0.1,2,3")
    assert list(import_file(path, leave_out=["position_rad"]).columns) == ["time_s", "current_A"]


def test_time_begins_at_zero_and_the_offset_is_kept(tmp_path: Path) -> None:
    recording = import_file(lines(tmp_path, "time_s,current_A", "1700000000.5,1", "1700000000.75,2"))
    assert recording.time_s.tolist() == [0.0, 0.25]
    assert recording.metadata["source"]["time_offset_s"] == 1700000000.5


def test_hole_of_the_time_axis_becomes_a_gap(tmp_path: Path) -> None:
    kept = [k for k in range(100) if not 40 <= k < 45]
    path = lines(tmp_path, "time_s,current_A", *(f"{k / 100},1" for k in kept))
    (gap,) = import_file(path).gaps
    assert (gap.row, gap.missing_samples, gap.cause) == (40, 5, "hole")


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (
            ["time_s,current_A", "0,1", "0.1,", "0.2,nan"],
            r"'current_A' has 2 NaN .* first at row 1 \(time 0.1 s\)",
        ),
        (["time_s,current_A", "0,1", "0.2,1", "0.1,1"], "backwards .* first at row 2: 0.1 s follows 0.2 s"),
        (
            ["t,current_A", "0,1", "0.1,1"],
            "no column 'time_s', only t, current_A; name it with --map time_s=",
        ),
        (["time_s,current_A", "0,1"], "has 1 samples; at least 2"),
        (["time_s,current_A", "2026-01-01 10:00:00,1"], "'time_s' holds timestamp"),
        (["time_s,current_A", "0,1,2"], "cannot read"),
        ([""], "cannot read"),
    ],
)
def test_unusable_file_is_refused_with_the_place(tmp_path: Path, rows: list[str], message: str) -> None:
    with pytest.raises(RecordingError, match=message):
        import_file(lines(tmp_path, *rows))


def test_unknown_source_column_is_refused_with_those_there_are(tmp_path: Path) -> None:
    path = lines(tmp_path, "time_s,current_A", "0,1", "0.1,2")
    with pytest.raises(RecordingError, match="'i' is not in the file; it has time_s, current_A"):
        import_file(path, parse_mappings(["current_ref_A=i"]))


@pytest.mark.parametrize(
    ("file_name", "message"),
    [
        ("run.xlsx", r"kinds known are \.csv, \.csv\.gz, \.parquet, \.mat"),
        ("nowhere.csv", "there is no such file"),
        ("bad.mat", "cannot read"),
        ("bad.h5", "cannot read"),
        ("bad.parquet", "cannot read"),
        ("bad.csv.gz", "cannot read"),
    ],
)
def test_file_that_cannot_be_read_is_refused(tmp_path: Path, file_name: str, message: str) -> None:
    path = tmp_path / file_name
    if file_name.startswith("bad"):
        path.write_bytes(b"\x1f\x8b\x08 not what the name says, and longer than any header would be" * 4)
    with pytest.raises(RecordingError, match=message):
        import_file(path)


def test_load_takes_our_recordings_and_files_with_our_names(tmp_path: Path) -> None:
    imported = load_recording(lines(tmp_path, "time_s,current_A", "0,1", "0.1,2"))
    ours = load_recording(write_recording(imported, tmp_path / "ours.parquet"))
    foreign: dict[str, npt.NDArray[np.float64]] = {name: imported.column(name) for name in imported.columns}
    pq.write_table(pa.table(foreign), tmp_path / "foreign.parquet")
    others = load_recording(tmp_path / "foreign.parquet")
    assert ours.column("current_A").tolist() == others.column("current_A").tolist() == [1.0, 2.0]
