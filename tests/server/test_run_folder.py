"""The run folder and its manifest: hashes, earlier runs, journals left open."""

import hashlib
import json
from pathlib import Path

from server.services.manifest import Ended, Manifest, StepEntry, describe_source, git_identity, versions
from server.services.run_folder import recover_folder, remove_previous, set_aside_previous


def written_manifest(folder: Path) -> Manifest:
    """Write a manifest of a run with one recording."""
    (folder / "records").mkdir(parents=True)
    (folder / "records" / "train.parquet").write_bytes(b"samples")
    step = StepEntry(index=0, kind="record", title="record train", ended=Ended.DONE)
    manifest = Manifest(campaign={"name": "trial"}, rig={"name": "rig"}, steps=[step], started="2026-01-01")
    manifest.write(folder)
    return manifest


def test_the_manifest_holds_the_hash_of_each_file(tmp_path: Path) -> None:
    written_manifest(tmp_path)
    content = json.loads((tmp_path / "manifest.json").read_text())
    expected = {"octets": 7, "sha256": hashlib.sha256(b"samples").hexdigest()}
    assert content["files"] == {"records/train.parquet": expected}
    assert (content["schema"], content["steps"][0]["ended"]) == ("jointscope.run/1", "done")


def test_the_manifest_names_program_and_libraries(tmp_path: Path) -> None:
    written_manifest(tmp_path)
    content = json.loads((tmp_path / "manifest.json").read_text())
    assert content["versions"] == versions()
    assert content["git"] == git_identity()
    assert {"jointscope", "numpy", "numba"} <= content["versions"].keys()


def test_an_input_file_is_kept_with_text_and_hash(tmp_path: Path) -> None:
    path = tmp_path / "campaign.yaml"
    path.write_text("name: trial\n")
    described = describe_source(path)
    assert described["text"] == "name: trial\n"
    assert described["sha256"] == hashlib.sha256(b"name: trial\n").hexdigest()


def test_an_earlier_run_is_moved_aside_and_stays_whole(tmp_path: Path) -> None:
    written_manifest(tmp_path)
    shelf = set_aside_previous(tmp_path)
    assert shelf == tmp_path / "previous" / "001"
    assert (shelf / "records" / "train.parquet").read_bytes() == b"samples"
    assert [entry.name for entry in tmp_path.iterdir()] == ["previous"]
    assert set_aside_previous(tmp_path) is None


def test_removing_an_earlier_run_leaves_other_files_alone(tmp_path: Path) -> None:
    written_manifest(tmp_path)
    (tmp_path / "notes.txt").write_text("mine")
    remove_previous(tmp_path)
    assert [entry.name for entry in tmp_path.iterdir()] == ["notes.txt"]


def test_a_manifest_that_points_outside_its_folder_deletes_nothing_there(tmp_path: Path) -> None:
    folder, precious = tmp_path / "run", tmp_path / "precious"
    folder.mkdir()
    precious.write_text("mine")
    (folder / "manifest.json").write_text(json.dumps({"files": {"../precious": {}}}))
    remove_previous(folder)
    assert precious.exists()


def test_a_folder_without_journals_needs_no_recovery(tmp_path: Path) -> None:
    told: list[str] = []
    recover_folder(tmp_path, told.append)
    assert told == []
