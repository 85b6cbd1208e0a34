"""Import and identification of data that others measured; docs/real_data.md holds the same commands and figures."""

import json
import os
from pathlib import Path
from typing import Any

import pytest

from server.cli.main import main

REPOSITORY = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("JOINTSCOPE_SHARED_DATA", REPOSITORY.parent / "shared" / "data"))

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not (DATA / "emps").is_dir(),
        reason=f"measured data are not part of the project; none in {DATA} (set JOINTSCOPE_SHARED_DATA)",
    ),
]


def run(*arguments: object) -> None:
    """Run a command that must succeed."""
    assert main([str(argument) for argument in arguments]) == 0


def free_run_r2(out: Path) -> dict[str, float]:
    """Return the adjusted R2 of each estimator's free run on the test record."""
    document: dict[str, Any] = json.loads((out / "identification.json").read_text())  # Any: JSON
    scores = {name: method["scores"]["test"]["free_run"] for name, method in document["methods"].items()}
    return {name: score["r2_adjusted"] for name, score in scores.items()}


def trivial_r2(out: Path) -> float:
    """Return the adjusted R2 of y(k) = y(k-1) on the test record."""
    document: dict[str, Any] = json.loads((out / "identification.json").read_text())  # Any: JSON
    return float(document["trivial"]["test"]["r2_adjusted"])


def test_emps_force_to_speed_derived_from_position(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    train, test, out = tmp_path / "train.parquet", tmp_path / "test.parquet", tmp_path / "out"
    run("import", DATA / "emps" / "emps_train.csv.gz", "--out", train)
    run("import", DATA / "emps" / "emps_test_pulses.csv.gz", "--out", test)
    columns = ("--input", "motor_force_N", "--output", "speed_m_s")
    methods = ("--sample-time", 0.02, "--methods", "rls,erls,rls_kf,rls_kf_ml")
    run("identify", "--train", train, "--test", test, *columns, *methods, "--out", out)
    found = free_run_r2(out)
    # A pole or a digit may move with the libraries; the order of the estimators and two digits must not.
    assert found["rls"] == pytest.approx(0.965, abs=0.005)
    assert found["erls"] == pytest.approx(0.966, abs=0.005)
    assert found["rls_kf"] < found["rls"] - 0.1
    assert trivial_r2(out) == pytest.approx(0.993, abs=0.001)
    assert "speed_m_s derived from position_m, zero phase" in capsys.readouterr().out


def test_ur10e_joint_1_current_to_speed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    train, test, out = tmp_path / "train.parquet", tmp_path / "test.parquet", tmp_path / "out"
    source = DATA / "ur10e" / "ur10e_joint1.csv"
    run("import", source, "--span", "0:30", "--out", train)
    run("import", source, "--span", "30:", "--out", test)
    run(
        "identify",
        "--train",
        train,
        "--test",
        test,
        "--input",
        "current_A",
        "--sample-time",
        0.05,
        "--out",
        out,
    )
    found = free_run_r2(out)
    assert found["rls"] == pytest.approx(0.893, abs=0.02)
    # Coulomb friction is most of this joint's friction, and no linear model holds it.
    assert max(found.values()) < 0.95
    assert "jitter 1.19 ms rms" in capsys.readouterr().out


def test_xl330_with_irregular_time_stamps(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    train, test, out = tmp_path / "train.parquet", tmp_path / "test.parquet", tmp_path / "out"
    run("import", DATA / "xl330_pendulum" / "xl330_m0.49_l0.1_kp400_sin_sin.csv", "--out", train)
    run("import", DATA / "xl330_pendulum" / "xl330_m0.49_l0.1_kp400_sin_time_square.csv", "--out", test)
    columns = ("--input", "motor_voltage_V", "--sample-time", 0.02)
    run("identify", "--train", train, "--test", test, *columns, "--out", out)
    found = free_run_r2(out)
    # Gravity is missing from a linear model of a pendulum: it cannot explain a large swing.
    assert found["rls"] == pytest.approx(0.329, abs=0.02)
    assert "jitter 0.15 ms rms" in capsys.readouterr().out
