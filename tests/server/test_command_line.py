"""The command line: exit codes, one clear line on stderr for each kind of wrong input, help with examples."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import daq.errors as daq_errors
from server.cli.exit_codes import ExitCode, exit_code
from server.cli.main import main
from server.errors import InputError, RigTrippedError

RecordingMaker = Callable[..., Path]
CampaignFile = Callable[[str], Path]
CONFIG = Path(__file__).resolve().parents[2] / "config"
COMMANDS = [
    "serve",
    "demo",
    "emulate",
    "run",
    "identify",
    "gap",
    "simulate",
    "import",
    "export",
    "devices",
    "token",
]
RECORD = """\
  - record:
      name: a
      duration_s: 5
      excitation: {kind: sine, amplitude_A: 0.5, period_s: 5, ramp_s: 1}
"""


def refusal(capsys: pytest.CaptureFixture[str], *arguments: object, code: int = 2) -> str:
    """Run a command that must fail with one line on stderr, and return that line."""
    assert main([str(argument) for argument in arguments]) == code
    error = capsys.readouterr().err
    assert error.startswith("jointscope: ")
    assert error.count("\n") == 1
    assert "Traceback" not in error
    return error


@pytest.mark.parametrize("command", COMMANDS)
def test_the_help_of_each_command_shows_an_example(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, "--help"]) == 0
    assert f"Example: jointscope {command}" in " ".join(capsys.readouterr().out.split())


def test_a_mistyped_command_is_answered_with_the_near_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert "Did you mean 'identify'?" in refusal(capsys, "idenify")


def test_a_missing_option_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert "Missing option '--train'" in refusal(capsys, "identify", "--test", "x", "--out", "y")


def test_an_unknown_key_is_answered_with_the_near_one(
    campaign_file: CampaignFile, capsys: pytest.CaptureFixture[str]
) -> None:
    path = campaign_file(RECORD.replace("period_s", "periode_s"))
    message = refusal(capsys, "run", path, "--dry-run")
    assert f'{path}:7: steps[0].record.excitation.periode_s: unknown key "periode_s"; did you mean' in message


def test_an_excitation_over_a_limit_is_refused(
    campaign_file: CampaignFile, capsys: pytest.CaptureFixture[str]
) -> None:
    path = campaign_file(RECORD.replace("0.5", "3"))
    assert "peak current of 3" in refusal(capsys, "run", path)


def test_a_dry_run_predicts_and_moves_nothing(
    campaign_file: CampaignFile, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert main(["run", str(campaign_file(RECORD)), "--dry-run", "--out", str(tmp_path / "out")]) == 0
    out = capsys.readouterr().out
    assert "nothing was moved" in out
    assert "record a (sine" in out
    assert not (tmp_path / "out").exists()


def test_a_port_that_does_not_exist_is_named_with_the_rig_file(
    campaign_file: CampaignFile, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    rig = tmp_path / "rig.yaml"
    text = (CONFIG / "rigs" / "emulated.yaml").read_text()
    rig.write_text(text.replace("url: emulate ", "url: /dev/ttyNONE "))
    message = refusal(capsys, "run", campaign_file(RECORD), "--rig", rig, "--out", tmp_path / "out")
    assert f"{rig}: link.url: " in message
    assert "/dev/ttyNONE" in message
    assert "does not exist" in message


def test_nan_in_a_recording_is_refused(
    make_recording: RecordingMaker, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    bad = make_recording("bad", n=100, current_A=np.full(100, np.nan))
    message = refusal(capsys, "identify", "--train", bad, "--test", bad, "--out", tmp_path / "out")
    assert f"{bad}: column 'current_A' has 100 NaN" in message


def test_a_missing_column_is_named(
    make_recording: RecordingMaker, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = make_recording("a")
    message = refusal(
        capsys, "identify", "--train", path, "--test", path, "--input", "torque_Nm", "--out", tmp_path / "o"
    )
    assert "column 'torque_Nm' is missing" in message


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--map", "speed_rad_s=n_rpm"], "'n_rpm' seems to be in rpm, 'speed_rad_s' is in rad/s"),
        (["--map", "speed_rad_s=n_rpm[A]"], "A cannot become rad/s"),
        (["--map", "speed_rad_s=speed"], "column 'speed' is not in the file; it has time_s, n_rpm"),
        (["--span", "5:1"], '--span: "5:1" must read FROM:TO'),
        (["--span", "50:60"], "no sample between 50 s and 60 s"),
    ],
)
def test_an_import_that_cannot_be_right_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    source = tmp_path / "log.csv"
    source.write_text("time_s,n_rpm\n0,60\n0.1,60\n0.2,60\n")
    out = tmp_path / "log.parquet"
    assert message in refusal(capsys, "import", source, "--out", out, *arguments)
    assert not out.exists()


def test_import_and_export_carry_values_in_si(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source, recording, table = tmp_path / "log.csv", tmp_path / "log.parquet", tmp_path / "log_si.csv"
    source.write_text("time_s,n_rpm\n0,60\n0.1,60\n0.2,120\n")
    assert main(["import", str(source), "-m", "speed_rad_s=n_rpm[rpm]", "-o", str(recording)]) == 0
    assert "3 samples" in capsys.readouterr().out
    assert main(["export", str(recording), "--out", str(table)]) == 0
    assert table.read_text().splitlines()[-1].startswith("0.2,12.566370614359172")


def test_an_export_to_an_unknown_format_is_refused(
    make_recording: RecordingMaker, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    message = refusal(capsys, "export", make_recording("a"), "--out", tmp_path / "a.xlsx")
    assert "name it with one of .csv, .mat" in message


def test_identify_prints_the_table_and_where_the_report_is(
    make_recording: RecordingMaker, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    train, test, out = make_recording("train"), make_recording("test", seed=2), tmp_path / "out"
    assert main(["identify", "--train", str(train), "--test", str(test), "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("first estimate, RLS: theta = [")
    assert "y(k) = y(k-1)" in printed
    assert f"report: {out / 'report.html'}" in printed
    assert (out / "identification.json").exists()


def test_debug_shows_the_traceback(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(tmp_path / "absent.yaml"), "--debug"]) == 2
    assert "Traceback" in capsys.readouterr().err


def test_emulate_without_a_scenario_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert "give --scenario FILE" in refusal(capsys, "emulate")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--sealed", "7"], "--sealed SEED and --answer FILE belong together"),
        (["--scenario", "absent.yaml"], "absent.yaml: no such scenario file"),
        (["--sealed", "7", "--answer", "a.json", "--speed", "0"], '--speed: "0" is neither max nor a factor'),
    ],
)
def test_an_emulator_that_cannot_be_is_refused(
    capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    assert message in refusal(capsys, "emulate", *arguments)


def test_devices_lists_or_says_that_there_is_none(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["devices"]) == 0
    assert capsys.readouterr().out.strip()


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (InputError("x"), ExitCode.WRONG_INPUT),
        (daq_errors.ExcitationLimitError("x", quantity="q", value=2.0, limit=1.0), ExitCode.WRONG_INPUT),
        (daq_errors.RecordingError("x"), ExitCode.WRONG_INPUT),
        (daq_errors.JournalWriteError("x"), ExitCode.FAILED),
        (daq_errors.LinkTimeoutError("x"), ExitCode.FAILED),
        (daq_errors.DeviceFaultError("x", faults=1), ExitCode.RIG_REFUSED),
        (daq_errors.DeviceRefusedError(status=4, command="RUN", remedy="x"), ExitCode.RIG_REFUSED),
        (daq_errors.ProtocolVersionError("x"), ExitCode.RIG_REFUSED),
        (RigTrippedError("x"), ExitCode.RIG_REFUSED),
        (RuntimeError("x"), ExitCode.FAILED),
    ],
)
def test_each_kind_of_error_has_its_exit_code(error: Exception, code: ExitCode) -> None:
    assert exit_code(error) is code


@pytest.mark.slow
def test_the_package_runs_as_a_module() -> None:
    command = [sys.executable, "-m", "server", "token", "revoke"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("jointscope: Missing argument")
