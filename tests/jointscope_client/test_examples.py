"""Every example, run as its head says, against the real service and the emulated controller."""

import os
import subprocess
import sys
from pathlib import Path

import httpx
import pytest

from jointscope_client.emulated_service import EmulatedRig
from tests.server.service.measured import MODEL, as_csv, measured_columns

REPOSITORY = Path(__file__).resolve().parents[2]
CAMPAIGN = """\
name: example
steps:
  - record: {name: train, duration_s: 5, excitation: {kind: sine, amplitude_A: 0.5, period_s: 5, ramp_s: 1}}
"""


def run(rig: EmulatedRig, example: str, *arguments: object) -> str:
    """Run an example to its end and return what it printed."""
    done = subprocess.run(
        [sys.executable, "-m", f"examples.{example}", *map(str, arguments)],
        cwd=REPOSITORY,
        env={**os.environ, "JOINTSCOPE_URL": rig.url, "JOINTSCOPE_TOKEN": rig.token},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def needs(rig: EmulatedRig, path: str) -> None:
    """Skip what a service without this address cannot do."""
    if path not in httpx.get(f"{rig.url}/openapi.json").json()["paths"]:
        pytest.skip(f"this service has no {path} yet")


def test_a_campaign_is_run_and_followed(emulated_rig: EmulatedRig, tmp_path: Path) -> None:
    needs(emulated_rig, "/api/v1/campaigns")
    path = tmp_path / "campaign.yaml"
    path.write_text(CAMPAIGN)
    printed = run(emulated_rig, "run_campaign", path, emulated_rig.id)
    assert "example: 1 steps" in printed
    assert "done" in printed
    assert "train: " in printed and " 0 lost" in printed


def test_a_joint_is_identified_and_followed(emulated_rig: EmulatedRig) -> None:
    printed = run(emulated_rig, "identify_joint", emulated_rig.id, 20)
    assert "samples, 0 lost: a1 = " in printed
    assert "done, " in printed
    assert "poles at [" in printed and "DC gain" in printed
    assert "greatest speed" in printed


def test_live_data_are_followed(emulated_rig: EmulatedRig) -> None:
    if not (REPOSITORY / "server" / "api" / "routers" / "live.py").is_file():  # stands in no OpenAPI document
        pytest.skip("this service has no live data yet")
    printed = run(emulated_rig, "follow_live", emulated_rig.id, 5)
    assert printed.count("rad/s") == 5


def test_a_measured_file_is_fetched_as_numpy(emulated_rig: EmulatedRig, measured_file: Path) -> None:
    printed = run(emulated_rig, "fetch_result", measured_file)
    assert "measured: 3000 samples of 0.01 s" in printed
    assert "500 points to draw 3000 samples" in printed


@pytest.mark.slow
def test_an_analysis_is_started_and_its_report_saved(emulated_rig: EmulatedRig, tmp_path: Path) -> None:
    for seed, name in ((1, "train"), (2, "test")):
        (tmp_path / f"{name}.csv").write_bytes(as_csv(measured_columns(seed)))
    (tmp_path / "model.yaml").write_text(MODEL.replace("bench", "example"))
    files = [tmp_path / name for name in ("model.yaml", "train.csv", "test.csv", "report.html")]
    printed = run(emulated_rig, "start_analysis", *files)
    assert "verdict: " in printed
    assert "example is now at version 2" in printed
    assert files[-1].read_text().startswith("<!doctype html>")
