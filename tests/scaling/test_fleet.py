"""`jointscope gap --fleet`: lists, folders, summaries, going on, and the same answers wherever it runs."""

import csv
import json
from pathlib import Path
from typing import Any

import pytest

from server.cli.main import main
from server.errors import InputError
from server.reports.fleet_page import render_fleet
from server.services.fleet import FleetRequest, run_fleet, spoken_time
from server.services.fleet_folder import FleetFolder
from server.services.fleet_list import read_fleet_list
from server.services.joint_job import JointAnswer, share_plotly
from tests.scaling.conftest import DaskProcesses
from tests.scaling.fleet_files import write_fleet

NAMED = {
    "joint": "rough", "error": None, "verdict": "named", "effects": ["coulomb_friction"],
    "equivalents": ["a", ["b", "c"]],
    "parameter_changes": {"inertia": [0.5, 0.6]}, "gap_before": 0.2, "gap_after": 0.01, "gap_closed": 0.95,
    "open_question": True, "notes": ["2 holes"], "cpu_s": 4.0,
}  # fmt: skip
FILES = dict.fromkeys(("gap.json", "model.yaml", "report.html", "next_campaign.yaml"), b"x")


def answers(folder: Path) -> dict[str, Any]:
    """Return the answers of a fleet's joints, without what depends on the machine."""
    return {path.parent.name: json.loads(path.read_text()) for path in folder.glob("*/gap.json")}


@pytest.mark.slow
def test_a_fleet_answers_what_it_can_and_goes_on_where_it_was(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    listed, out = write_fleet(tmp_path), tmp_path / "out"
    arguments = ["gap", "--fleet", str(listed), "--out", str(out), "--jobs", "2"]
    assert main(arguments) == 1
    captured = capsys.readouterr()
    assert "2 of 4 joints without an answer" in captured.err
    assert "4/4] " in captured.out
    summary = json.loads((out / "fleet.json").read_text())
    assert summary["counts"] == {"named": 2, "none": 0, "unknown": 0, "error": 2, "waiting": 0}
    errors = {entry["joint"]: entry["error"] for entry in summary["joints"]}
    assert "idle.parquet: current_A is constant" in errors["idle"]
    assert "nowhere.parquet: no such file" in errors["absent"]
    before = (out / "rough" / "gap.json").stat().st_mtime_ns
    assert main(arguments) == 1
    assert "4 joints, 2 finished before, 2 to do" in capsys.readouterr().out
    assert (out / "rough" / "gap.json").stat().st_mtime_ns == before


@pytest.mark.slow
def test_a_fleet_on_a_cluster_that_loses_a_worker_gives_the_same_answers(
    tmp_path: Path, dask_processes: DaskProcesses
) -> None:
    listed = write_fleet(tmp_path)
    here = run_fleet(FleetRequest(list_file=listed, out=tmp_path / "here", jobs=1), lambda _: None)

    def kill_one(line: str) -> None:
        if line.startswith("[1/"):  # the two joints with an answer are then still to come, or half done
            dask_processes.workers[0].kill()

    there = run_fleet(
        FleetRequest(list_file=listed, out=tmp_path / "there", cluster=dask_processes.address), kill_one
    )
    assert here.counts == there.counts
    assert answers(tmp_path / "here") == answers(tmp_path / "there")
    assert answers(tmp_path / "here").keys() == {"rough", "short"}
    # The worker's own copies of the files are nobody's business.
    assert not any(b"jointscope-" in path.read_bytes() for path in (tmp_path / "there").glob("*/*.*"))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "no joint in the list"),
        ("joint,model,train,test\n", "no joint in the list"),
        ("joint,model,train\na,m,t\n", "column 'test' is missing"),
        ("joint,model,train,test\na,m,t,t\nA,m,t,t\n", "joint 'a' stands there twice"),
        ("joint,model,train,test\n../a,m,t,t\n", "'../a' cannot name a folder"),
        ("joint,model,train,test\na,m,,t\n", "joint a: no train given"),
        ("joint,model,train,test\na,m,t,t,u\n", ":2: more fields than columns; separate several recordings"),
    ],
)
def test_a_mistake_in_the_list_is_named(content: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "joints.csv"
    path.write_text(content)
    with pytest.raises(InputError, match=message.replace("(", r"\(")) as caught:
        read_fleet_list(path)
    assert str(path) in str(caught.value)


def test_options_that_exclude_each_other_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = str(tmp_path / "out")
    assert main(["gap", "--fleet", "a.csv", "--model", "m.yaml", "--out", out]) == 2
    assert "leave out the others" in capsys.readouterr().err
    assert main(["gap", "--model", "m.yaml", "--out", out]) == 2
    assert "--model, --train and --test are needed" in capsys.readouterr().err
    assert (
        main(
            ["gap", "--fleet", str(write_fleet(tmp_path)), "--jobs", "2", "--cluster", "tcp://h:1", "-o", out]
        )
        == 2
    )
    assert "--jobs and --cluster exclude each other" in capsys.readouterr().err


@pytest.fixture
def folder(tmp_path: Path) -> FleetFolder:
    """Return a fleet's folder in which joint `rough` is finished."""
    joints = read_fleet_list(write_fleet(tmp_path))
    found = FleetFolder(tmp_path / "out", joints)
    found.write_joint(joints[0], JointAnswer(entry=NAMED, files=FILES))
    return found


def test_a_joint_is_done_again_when_a_file_of_it_changed(folder: FleetFolder, tmp_path: Path) -> None:
    joint = read_fleet_list(tmp_path / "joints.csv")[0]
    assert folder.is_finished(joint)
    (tmp_path / "model.yaml").write_text((tmp_path / "model.yaml").read_text() + "# changed\n")
    assert not folder.is_finished(joint)


def test_a_failed_joint_leaves_no_old_answer_behind(folder: FleetFolder, tmp_path: Path) -> None:
    joint = read_fleet_list(tmp_path / "joints.csv")[0]
    folder.write_joint(joint, JointAnswer(entry={"joint": "rough", "error": "no speed"}))
    assert not folder.is_finished(joint)
    assert [path.name for path in (tmp_path / "out" / "rough").iterdir()] == ["joint.json"]


def test_the_summary_holds_every_joint_of_the_list(folder: FleetFolder, tmp_path: Path) -> None:
    counts = folder.write_summary()
    assert counts == {"named": 1, "none": 0, "unknown": 0, "error": 0, "waiting": 3}
    with (tmp_path / "out" / "fleet.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["joint"] for row in rows] == ["rough", "short", "idle", "absent"]
    assert rows[0]["equivalents"] == "a; b with c"
    assert rows[0]["parameter_changes"] == "inertia 0.5 -> 0.6"


def test_the_page_links_reports_and_carries_its_own_numbers() -> None:
    wrong = {"joint": "<b>", "verdict": "error", "error": "a < b", "report": None}
    page = render_fleet({"named": 1, "error": 1}, [{**NAMED, "report": "rough/report.html"}, wrong])
    assert '<a href="rough/report.html">rough</a>' in page
    assert '<td data-n="0.95">95.00%</td>' in page
    assert "&lt;b&gt;" in page
    assert "a &lt; b" in page
    assert "coulomb_friction (or a, b with c)" in page


def test_reports_of_a_fleet_share_one_drawing_library() -> None:
    from plotly.offline import get_plotlyjs

    page = f"<head><script type='text/javascript'>{get_plotlyjs()}</script></head><div>plot</div>"
    assert share_plotly(page) == '<head><script src="../plotly.min.js"></script></head><div>plot</div>'
    assert share_plotly("<p>no plot</p>") == "<p>no plot</p>"


@pytest.mark.parametrize(("seconds", "text"), [(5.2, "5 s"), (600.0, "10 min"), (9000.0, "2.5 h")])
def test_times_are_told_in_the_unit_a_person_would_use(seconds: float, text: str) -> None:
    assert spoken_time(seconds) == text
