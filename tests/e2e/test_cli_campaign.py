"""Campaigns from the command line, over the real driver and the emulated controller's process."""

import json
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from daq.recording.store import read_recording

REPOSITORY = Path(__file__).resolve().parents[2]
CONFIG = REPOSITORY / "config"
NOMINAL = CONFIG / "scenarios" / "nominal.yaml"
DEADLINE_S = 240.0
RECORD = """\
name: trial
rig: {rig}
steps:
  - record:
      name: a
      duration_s: {duration_s}
      excitation: {{kind: sine, amplitude_A: {amplitude_A}, period_s: 5, ramp_s: 1}}
"""

pytestmark = pytest.mark.slow


def jointscope(*arguments: object) -> subprocess.CompletedProcess[str]:
    """Run the command line as a process of its own."""
    command = [sys.executable, "-m", "server", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=DEADLINE_S)


def campaign(folder: Path, *, duration_s: float = 5.0, amplitude_a: float = 0.5) -> Path:
    """Write a campaign of one record step."""
    path, rig = folder / "campaign.yaml", folder / "rig.yaml"
    text = (CONFIG / "rigs" / "emulated.yaml").read_text()
    # A machine that runs other tests beside this one may stall the host for longer than the usual lease.
    text = text.replace("lease_ms: 1000", "lease_ms: 2000").replace("../scenarios", str(CONFIG / "scenarios"))
    rig.write_text(text)
    path.write_text(RECORD.format(rig=rig, duration_s=duration_s, amplitude_A=amplitude_a))
    return path


def manifest_of(folder: Path) -> dict[str, object]:
    """Return the run folder's manifest."""
    content: dict[str, object] = json.loads((folder / "manifest.json").read_text())
    return content


def test_a_campaign_runs_from_the_serial_line_to_the_report(tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = jointscope("run", CONFIG / "campaigns" / "quick.yaml", "--emulate", NOMINAL, "--out", out)
    assert done.returncode == 0, done.stderr
    assert "y(k) = y(k-1)" in done.stdout
    manifest = manifest_of(out)
    assert [step["ended"] for step in manifest["steps"]] == ["done"] * 5  # type: ignore[attr-defined]  # JSON
    assert {"records/train.parquet", "identification.json", "report.html"} <= set(manifest["files"])  # type: ignore[call-overload]  # JSON
    gain = json.loads((out / "identification.json").read_text())["methods"]["rls"]["static_gain"]["value"]
    # 1.0 N m/A over 0.9 N m s/rad, config/rigs/emulated.yaml; 20 s of data know it to a few percent.
    assert gain == pytest.approx(1.0 / 0.9, rel=0.05)


def test_a_campaign_names_the_effect_that_its_rig_hides(tmp_path: Path) -> None:
    out, hidden = tmp_path / "out", CONFIG / "scenarios" / "hidden_friction.yaml"
    done = jointscope("run", CONFIG / "campaigns" / "hidden.yaml", "--emulate", hidden, "--out", out)
    assert done.returncode == 0, done.stderr
    assert "+ coulomb_friction: level 0.1" in done.stdout
    answer = json.loads((out / "gap.json").read_text())
    level = answer["steps"][1]["parameters"]["level"]["value"]
    assert level == pytest.approx(0.15, rel=0.02)  # N m, the scenario's own; 40 s know it to 0.3 %
    assert (answer["verdict"], answer["effects"]) == ("named", ["coulomb_friction"])
    assert answer["gap_closed"] > 0.9
    step = manifest_of(out)["steps"][-1]  # type: ignore[index]  # JSON
    assert step["figures"] == {"verdict": "named", "effects": ["coulomb_friction"]}
    assert set(step["files"]) <= set(manifest_of(out)["files"])  # type: ignore[call-overload]  # JSON


def test_no_sample_is_lost_and_the_recording_tells_its_story(tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = jointscope("run", campaign(tmp_path), "--out", out)
    assert done.returncode == 0, done.stderr
    recording = read_recording(out / "records" / "a.parquet")
    assert recording.n >= 5 * 2500
    assert recording.gaps == ()
    assert recording.metadata["samples"]["lost"] == 0
    assert recording.metadata["rig"] == "emulated"
    assert recording.metadata["excitation"]["kind"] == "sine"
    assert recording.metadata["ended"]["reason"] == "done"


def test_ctrl_c_leaves_a_whole_recording_and_a_manifest_that_says_so(tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = [
        sys.executable,
        "-m",
        "server",
        "run",
        str(campaign(tmp_path, duration_s=500.0)),
        "--speed",
        "1",
    ]
    process = subprocess.Popen(
        [*command, "--out", str(out)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    wait_for_octets(out / "records" / "a.journal", process)
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=DEADLINE_S)
    assert process.returncode == 1
    assert error.startswith("jointscope: ")
    assert manifest_of(out)["ended"] == "interrupted"
    recording = read_recording(out / "records" / "a.parquet")
    assert recording.metadata["ended"]["reason"] == "stopped"
    assert recording.n > 0


def test_a_killed_run_is_recovered_at_the_next_start_in_its_folder(tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = [
        sys.executable,
        "-m",
        "server",
        "run",
        str(campaign(tmp_path, duration_s=500.0)),
        "--speed",
        "1",
    ]
    process = subprocess.Popen(
        [*command, "--out", str(out)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    wait_for_octets(out / "records" / "a.journal", process)
    process.kill()
    process.communicate(timeout=DEADLINE_S)
    again = jointscope("run", campaign(tmp_path), "--out", out)
    assert again.returncode == 0, again.stderr
    assert "from a journal that was left open" in again.stdout
    earlier = out / "previous" / "001"
    assert read_recording(earlier / "records" / "a.parquet").metadata["ended"]["closed"] is False
    assert manifest_of(out)["ended"] == "done"


def test_a_trip_ends_the_run_with_code_3_and_keeps_the_recording(tmp_path: Path) -> None:
    scenario = tmp_path / "loaded.yaml"
    # 1 N m against 0.9 N m s/rad drives the joint past the end of its travel within a minute.
    load = "{id: load_torque_offset, parameters: {torque_nm: -1.0}}"
    scenario.write_text(f"name: loaded\neffects: [{load}]\n")
    out = tmp_path / "out"
    done = jointscope("run", campaign(tmp_path, duration_s=60.0), "--emulate", scenario, "--out", out)
    assert done.returncode == 3, done.stderr
    assert re.fullmatch(r"jointscope: .*travel.*\n", done.stderr)
    assert manifest_of(out)["ended"] == "tripped"
    assert read_recording(out / "records" / "a.parquet").n > 0


def test_a_full_disk_stops_the_run_and_leaves_what_was_written_readable(tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = f"ulimit -f 300; exec {sys.executable} -m server run {campaign(tmp_path, duration_s=500.0)} --out {out}"
    done = subprocess.run(
        ["bash", "-c", command], capture_output=True, text=True, check=False, timeout=DEADLINE_S
    )
    assert done.returncode == 1
    assert re.fullmatch(r"jointscope: .*a.journal cannot be written after \d+ octets: .*\n", done.stderr)
    assert read_recording(out / "records" / "a.parquet").n > 10_000
    assert manifest_of(out)["ended"] == "failed"


def test_a_value_that_the_controller_does_not_take_is_named_in_the_campaign(tmp_path: Path) -> None:
    path = campaign(tmp_path)
    path.write_text(path.read_text() + "  - set: {parameter: centring_gain_A_rad, value: 9}\n")
    done = jointscope("run", path, "--out", tmp_path / "out")
    assert done.returncode == 2
    assert "steps[1].set.value: centring_gain_A_rad=9 must lie in [0, 0.2] A/rad" in done.stderr


def wait_for_octets(path: Path, process: subprocess.Popen[str]) -> None:
    """Return when the journal has samples; fail when the process ends before."""
    while not path.exists() or path.stat().st_size < 50_000:
        try:
            process.wait(0.05)
        except subprocess.TimeoutExpired:
            continue
        pytest.fail(f"the run ended before it was stopped: {process.communicate()}")
