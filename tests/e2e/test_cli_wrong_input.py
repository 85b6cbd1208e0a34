"""What a user gets who gives wrong input: one line that names it, and the right exit code, on the real chain."""

import os
import re
import select
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import serial
import yaml

from daq.driver.options import RigOptions
from daq.driver.rig import open_rig
from daq.protocol.codes import DriveState
from daq.recording.store import read_recording
from server.cli.main import main
from tests.e2e.conftest import SINE, CampaignFiles, Emulate

MakeCampaign = Callable[..., CampaignFiles]
Refusal = Callable[..., str]


@pytest.fixture
def refusal(capsys: pytest.CaptureFixture[str]) -> Refusal:
    """Return a function that runs a command which must fail with one line, and returns that line."""

    def run(*arguments: object, code: int = 2) -> str:
        returned = main([str(argument) for argument in arguments])
        error = capsys.readouterr().err
        assert returned == code, error
        assert error.startswith("jointscope: ") and error.count("\n") == 1
        return error

    return run


@pytest.mark.parametrize(
    ("excitation", "message"),
    [
        (
            {**SINE, "periode_s": 5},
            'steps[0].record.excitation.periode_s: unknown key "periode_s"; did you mean "period_s"?',
        ),
        (
            {**SINE, "period_s": "5 V"},
            "steps[0].record.excitation.period_s: '5 V' is in V; allowed here: s, ",
        ),
        ({**SINE, "amplitude_A": 2.5}, "peak current of 2.512 A exceeds the limit of 2 A"),
        (
            {"kind": "trapezoid", "amplitude_A": 1.9, "period_s": 5, "rise_fraction": 0.1, "ramp_s": 0.5},
            "I2t current of 1.",
        ),
        (
            {"kind": "trapezoid", "amplitude_A": 0.5, "period_s": 1, "rise_fraction": 0.0005, "ramp_s": 0.5},
            "slew of 1250 A/s exceeds the limit of 500 A/s",
        ),
        ({**SINE, "period_s": 150, "amplitude_A": 1.2}, "travel"),
    ],
    ids=["unknown key", "unit", "peak", "I2t", "slew", "travel"],
)
def test_a_campaign_that_cannot_be_is_refused_before_anything_starts(
    make_campaign: MakeCampaign, refusal: Refusal, excitation: dict[str, object], message: str
) -> None:
    files = make_campaign(100.0, excitation)
    error = refusal("run", files.campaign)
    assert f"{files.campaign}:" in error
    assert message in error


def test_an_excitation_that_would_run_too_fast_is_refused(
    make_campaign: MakeCampaign, refusal: Refusal
) -> None:
    files = make_campaign()
    files.change_rig("limits", speed_rad_s=0.3)
    assert "speed of 0." in refusal("run", files.campaign)


def test_a_missing_column_and_a_nan_are_named(tmp_path: Path, refusal: Refusal) -> None:
    rows = ["time_s,current_A,speed_rad_s", *(f"{k / 10},{k % 7},{k % 5}" for k in range(200))]
    source, recording = tmp_path / "log.csv", tmp_path / "log.parquet"
    source.write_text("\n".join([*rows, "20.0,nan,0"]))
    error = refusal("import", source, "--out", recording)
    assert f"{source}: column 'current_A' has 1 NaN" in error
    assert "the first at row 200 (time 20 s); remove those rows" in error
    source.write_text("\n".join(rows))
    assert main(["import", str(source), "--out", str(recording)]) == 0
    names = ("--train", recording, "--test", recording, "--out", tmp_path / "out")
    assert "column 'torque_Nm' is missing" in refusal("identify", *names, "--input", "torque_Nm")
    map_error = refusal("import", source, "--map", "current_A=iq", "--out", tmp_path / "other.parquet")
    assert "column 'iq' is not in the file; it has time_s, current_A, speed_rad_s" in map_error


@pytest.mark.parametrize(
    ("url", "message"),
    [
        ("/dev/ttyUSB98", "link.url: /dev/ttyUSB98 does not exist"),
        ("/etc/hostname", "cannot be opened as a serial port"),
        ("socket://127.0.0.1:9", "socket://127.0.0.1:9"),
        ("http://rig", "http"),
    ],
)
def test_a_port_that_leads_nowhere_is_named(
    make_campaign: MakeCampaign, refusal: Refusal, tmp_path: Path, url: str, message: str
) -> None:
    files = make_campaign()
    files.change_rig("link", url=url)
    error = refusal("run", files.campaign, "--out", tmp_path / "out")
    assert f"{files.rig}: link.url: " in error
    assert message in error


@pytest.mark.slow
def test_a_port_that_is_taken_is_told(
    make_campaign: MakeCampaign, refusal: Refusal, emulate: Emulate, tmp_path: Path
) -> None:
    files, port = make_campaign(), emulate("nominal", "max")
    files.change_rig("link", url=str(port))
    with serial.Serial(str(port), 115_200, exclusive=True):
        error = refusal("run", files.campaign, "--out", tmp_path / "out")
    assert f"link.url: {port} is taken by another program; close it there, or choose another port" in error


@pytest.mark.slow
def test_a_baud_that_the_controller_does_not_have_is_answered_with_those_it_has(
    make_campaign: MakeCampaign, refusal: Refusal, tmp_path: Path
) -> None:
    files = make_campaign()
    files.change_rig("link", baud=1_000_000)
    error = refusal("run", files.campaign, "--out", tmp_path / "out")
    assert (
        "the controller has no 1000000 baud; choose one of 9600" in error or "choose one of 115200" in error
    )


@pytest.mark.slow
def test_a_controller_that_was_left_at_another_baud_is_not_understood_but_explained(
    make_campaign: MakeCampaign, refusal: Refusal, emulate: Emulate, tmp_path: Path
) -> None:
    files, port = make_campaign(), emulate("nominal", "1")
    with open_rig(str(port), RigOptions(baud=460_800)) as rig:
        assert rig.baud == 460_800
    files.change_rig("link", url=str(port))
    error = refusal("run", files.campaign, "--out", tmp_path / "out")
    assert "no controller answered at 115200 baud" in error
    assert "octets come in but make no frames: wrong baud?" in error
    assert "rates to try: 115200, 230400, 460800" in error


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "code", "message"),
    [
        (
            "newer_protocol",
            3,
            "the controller speaks .* of the protocol, this program version 1 only; update",
        ),
        ("wrong_dictionary", 1, "HELLO announced .* nothing is run: restart the controller"),
    ],
)
def test_a_controller_that_cannot_be_trusted_is_not_driven(
    make_campaign: MakeCampaign, refusal: Refusal, tmp_path: Path, fault: str, code: int, message: str
) -> None:
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(yaml.safe_dump({"name": "odd", "faults": [{"name": fault}]}))
    arguments = ("run", make_campaign().campaign, "--emulate", scenario, "--out", tmp_path / "out")
    assert re.search(message, refusal(*arguments, code=code))


@pytest.mark.slow
def test_a_full_disk_stops_the_run_leaves_the_drive_at_rest_and_the_rest_readable(
    make_campaign: MakeCampaign, emulate: Emulate, tmp_path: Path
) -> None:
    files, port, out = make_campaign(500.0), emulate("nominal", "max"), tmp_path / "out"
    files.change_rig("link", url=str(port))
    command = f"ulimit -f 300; exec {sys.executable} -m server run {files.campaign} --out {out}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 1
    assert "a.journal cannot be written after" in done.stderr
    assert "free some space" in done.stderr
    assert read_recording(out / "records" / "a.parquet").n > 10_000
    with open_rig(str(port)) as rig:
        while rig.status is None:
            rig.next_blocks(0.05)
        assert (rig.status.state, rig.status.faults) == (DriveState.IDLE, 0)


@pytest.mark.slow
@pytest.mark.parametrize("command", ["run", "demo"])
def test_a_killed_run_leaves_no_emulated_controller_behind(
    make_campaign: MakeCampaign, tmp_path: Path, command: str
) -> None:
    what = [str(make_campaign(500.0).campaign), "--speed", "1"] if command == "run" else []
    arguments = [sys.executable, "-m", "server", command, *what, "--out", str(tmp_path / "out")]
    process = subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert any("emulated controller on" in line for line in process.stdout)
    (child,) = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    emulator = os.pidfd_open(int(child))
    process.kill()
    process.communicate()
    with os.fdopen(emulator):
        ready, _, _ = select.select(
            [emulator], [], [], 30.0
        )  # a process's descriptor is ready when it has ended
    assert ready
