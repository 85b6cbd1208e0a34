"""Every fault of the emulator by name, through the whole chain: how the campaign ends, and what it says."""

import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import yaml

from daq.driver.options import RigOptions
from daq.driver.rig import open_rig
from daq.recording.store import read_recording
from server.cli.main import main
from tests.e2e.conftest import CampaignFiles, Emulate, assert_every_hole_is_told

pytestmark = pytest.mark.slow

MakeCampaign = Callable[..., CampaignFiles]
DONE = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A fault, and what a campaign must make of it.

    Attributes:
        fault: entry of the scenario.
        code: exit code of the command line.
        message: pattern of the line on stderr, empty for none.
        cause: cause of the gaps, empty where nothing may be missing.
    """

    fault: dict[str, object]
    code: int = 0
    message: str = DONE
    cause: str = ""


# Idle, the controller keeps to the wall clock: by 12 s of its time the recording has begun on the slowest machine,
# and at full speed it then runs through the fault at once.
AT_S = 12
CASES = (
    Case(fault={"name": "bit_flips", "rate": 1e-4, "seed": 1}, cause="loss"),
    Case(fault={"name": "dropped_bytes", "rate": 1e-4, "seed": 2}, cause="loss"),
    Case(fault={"name": "duplicated_bytes", "rate": 1e-4, "seed": 3}, cause="loss"),
    Case(fault={"name": "bursts", "rate": 1e-4, "magnitude": 40, "seed": 4}, cause="loss"),
    Case(fault={"name": "stall", "at_s": AT_S, "duration_s": 0.3}),
    Case(fault={"name": "disconnect", "at_s": AT_S, "duration_s": 0.2}, cause="reconnect"),
    Case(
        fault={"name": "disconnect", "at_s": AT_S, "duration_s": 3},
        cause="reconnect",
        code=3,
        message="the drive's lease ran out .* because the link was lost in between; check the cable",
    ),
    # Nothing comes after the last sample of a run that a restart has ended: no hole, but a cause.
    Case(
        fault={"name": "reboot", "at_s": AT_S},
        code=3,
        message="the controller restarted in mid-run, the drive is off; check its supply",
    ),
    Case(fault={"name": "tick_jump", "at_s": AT_S, "magnitude": 1000}, cause="tick_jump"),
    Case(fault={"name": "tick_jump", "at_s": AT_S, "magnitude": -1000}, cause="tick_jump"),
    Case(
        fault={"name": "stuck_sensor", "at_s": AT_S},
        code=3,
        message="sensor: The position sensor is stuck. Check the potentiometer and its supply",
    ),
    Case(fault={"name": "hall_offset", "at_s": AT_S, "magnitude": 0.1}),
    Case(
        fault={"name": "over_current", "at_s": AT_S}, code=3, message="over_current: .*Check the motor cable"
    ),
)


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.fault['name']}-{case.code}")
def test_a_fault_ends_as_documented_with_every_missing_sample_counted(
    case: Case, tmp_path: Path, make_campaign: MakeCampaign, capsys: pytest.CaptureFixture[str]
) -> None:
    manifest, error = run_with(case, tmp_path, make_campaign, capsys)
    assert re.search(case.message, error), error
    (step,) = manifest["steps"]
    recording = read_recording(tmp_path / "out" / "records" / "a.parquet")
    assert_every_hole_is_told(recording)
    assert {gap.cause for gap in recording.gaps} == ({case.cause} if case.cause else set())
    assert step["figures"]["samples_received"] == recording.n
    assert step["figures"]["samples_lost"] == recording.metadata["samples"]["lost"]


def run_with(
    case: Case, tmp_path: Path, make_campaign: MakeCampaign, capsys: pytest.CaptureFixture[str]
) -> tuple[dict[str, Any], str]:
    """Run a campaign on an emulated rig with one fault; return the manifest and what stood on stderr."""
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(yaml.safe_dump({"name": "faulty", "faults": [case.fault]}))
    arguments = [
        "run",
        make_campaign(duration_s=20.0).campaign,
        "--emulate",
        scenario,
        "--out",
        tmp_path / "out",
    ]
    code = main([str(argument) for argument in arguments])
    error = capsys.readouterr().err
    assert code == case.code, error
    manifest: dict[str, Any] = json.loads((tmp_path / "out" / "manifest.json").read_text())  # Any: JSON
    return manifest, error


def test_a_latched_fault_is_told_and_cleared_only_when_asked(
    emulate: Emulate, make_campaign: MakeCampaign, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files, port = make_campaign(duration_s=2.0), str(emulate("nominal", "max"))
    files.change_rig("link", url=port)
    with open_rig(port, RigOptions()) as rig:
        rig.estop()
    run = ["run", str(files.campaign), "--rig", str(files.rig), "--out"]
    assert main([*run, str(tmp_path / "refused")]) == 3
    assert "--clear-fault" in capsys.readouterr().err
    assert main([*run, str(tmp_path / "cleared"), "--clear-fault"]) == 0
