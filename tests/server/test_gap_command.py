"""`jointscope gap` and `simulate`, and the gap step: answers in words and files, and one line for what is wrong."""

import json
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from threading import Event

import numpy as np
import pytest
import yaml

from discrepancy.evaluate import Score
from discrepancy.model.reader import parse_model
from discrepancy.model.schema import EffectTerm, Quantity
from discrepancy.result import GapResult, ParameterChange, ResultStep
from server.cli.main import main
from server.config.campaign import Campaign, GapStep
from server.config.load import load_model
from server.reports.gap_words import describe_gap
from server.services.discrepancy import GapAnalysis, open_for_model, read_joint_model
from server.services.workers import WorkerPool

RecordingMaker = Callable[..., Path]
MODEL = Path(__file__).resolve().parents[2] / "config" / "models" / "joint1.yaml"
# What tests/server/conftest.py simulates: gain 1.1 and time constant 0.55 s.
TRUE_MODEL = """\
name: exact
outputs: [speed_rad_s]
input_hold: hold
parameters:
  inertia: {value: 0.5, unit: kg m^2, fixed: true}
  viscous_friction: {value: 0.9090909, unit: N m s/rad}
  torque_constant: {value: 1.0, unit: N m/A}
"""


@pytest.fixture
def exact_model(tmp_path: Path) -> Path:
    """Return the model file of the joint that the recordings come from."""
    path = tmp_path / "exact.yaml"
    path.write_text(TRUE_MODEL)
    return path


def refusal(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """Run a command that must refuse with one line on stderr, and return that line."""
    assert main([str(argument) for argument in arguments]) == 2
    error = capsys.readouterr().err
    assert error.startswith("jointscope: ")
    assert error.count("\n") == 1
    assert "Traceback" not in error
    return error


@pytest.mark.slow
def test_gap_writes_its_answer_and_says_it(
    exact_model: Path, make_recording: RecordingMaker, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    train, test, out = make_recording("train"), make_recording("test", seed=2), tmp_path / "out"
    arguments = ["gap", "--model", exact_model, "--train", train, "--test", test, "--out", out, "--jobs", 1]
    assert main([str(argument) for argument in arguments]) == 0
    printed = capsys.readouterr().out
    answer = json.loads((out / "gap.json").read_text())
    assert answer["schema"] == "jointscope.gap/1"
    assert f"verdict: {answer['verdict']}: " in printed
    assert all(f"+ {name}: " in printed for name in answer["effects"])
    assert f"report: {out / 'report.html'}" in printed
    assert (out / "report.html").stat().st_size > 1_000_000  # it carries its own drawing library
    assert read_joint_model(out / "model.yaml").version == 2
    experiment = out / "next_campaign.yaml"
    assert experiment.exists() == (answer["next_experiment"] is not None)
    if experiment.exists():
        assert load_model(experiment, Campaign).rig is None


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ("current", "train.parquet: current_A is constant"),
        ("column", "train.parquet: column 'current_A' of model 'joint1' is missing"),
        ("same", "is the same recording as"),
    ],
)
def test_recordings_that_cannot_answer_are_named_by_their_file(
    wrong: str,
    message: str,
    make_recording: RecordingMaker,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    columns: dict[str, dict[str, np.ndarray | None]] = {
        "current": {"current_A": np.full(6000, 0.5)},
        "column": {"current_A": None},
        "same": {},
    }
    train = make_recording("train", **columns[wrong])
    test = train if wrong == "same" else make_recording("test", seed=2)
    error = refusal(capsys, "gap", "-m", MODEL, "--train", train, "--test", test, "--out", tmp_path / "out")
    assert message in error
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("parameters: {inertia: 1, friction: 2}", "parameters.friction: unknown parameter; allowed are"),
        ("parameters: {viscous_friction: 1}", "inertia (or mass) is missing"),
        ("parameters: {inertia: 1}\neffects: [{id: magic}]", "'magic' is not in the catalogue"),
        ("parameters: {inertia: 1}\neffects: 5", "effects: 5 is not allowed"),
        ("parameters: {inertia: 1}\nversion: new", "version: 'new' is not a finite number"),
        ("- 1", "a model file is a mapping with"),
        ("a: [", "not readable as YAML"),
    ],
)
def test_a_mistake_in_a_model_file_is_named(
    content: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "model.yaml"
    path.write_text(content)
    error = refusal(capsys, "gap", "-m", path, "--train", "a", "--test", "b", "--out", tmp_path / "out")
    assert str(path) in error
    assert message in error


def test_a_missing_model_file_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "absent.yaml"
    assert f"{path}: no such model file" in refusal(capsys, "simulate", "-m", path, "--input", "a.parquet")


def test_simulate_reproduces_the_joint_that_the_model_describes(
    exact_model: Path, make_recording: RecordingMaker, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "sim.csv"
    recording = make_recording("a")
    arguments = ["simulate", "--model", exact_model, "--input", recording, "--out", out, "--plot"]
    assert main([str(argument) for argument in arguments]) == 0
    assert "speed_rad_s: rms error" in capsys.readouterr().out
    table = np.genfromtxt(out, delimiter=",", names=True)
    # 1e-4 rad/s of noise, and what a straight line between samples of a held current leaves.
    assert np.std(table["speed_rad_s"] - table["speed_rad_s_simulated"]) < 3e-3 * np.std(table["speed_rad_s"])
    assert (tmp_path / "sim.png").stat().st_size > 10_000


def test_simulate_predicts_an_output_that_was_not_recorded(
    exact_model: Path, make_recording: RecordingMaker, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recording, out = make_recording("a", speed_rad_s=None), tmp_path / "sim.parquet"
    assert main(["simulate", "-m", str(exact_model), "-i", str(recording), "-o", str(out)]) == 0
    assert "speed_rad_s: not in the recording" in capsys.readouterr().out
    from daq.recording.store import read_recording

    assert np.std(read_recording(out).column("speed_rad_s_simulated")) > 0.1


def test_a_speed_that_is_missing_is_derived_from_the_position(make_recording: RecordingMaker) -> None:
    position = np.cumsum(np.sin(np.arange(6000) * 0.01)) * 0.01
    recording = open_for_model(
        make_recording("a", speed_rad_s=None, position_rad=position), read_joint_model(MODEL)
    )
    inner = slice(100, -100)
    expected = np.sin(np.arange(6000) * 0.01)
    assert np.max(np.abs(recording.column("speed_rad_s")[inner] - expected[inner])) < 0.02


def test_a_gap_step_whose_model_is_missing_is_refused_before_anything_moves(
    campaign_file: Callable[[str], Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record = "{name: NAME, duration_s: 5, excitation: {kind: sine, amplitude_A: 0.5, period_s: 5, ramp_s: 1}}"
    steps = "".join(f"  - record: {record.replace('NAME', name)}\n" for name in "ab")
    path = campaign_file(f"{steps}  - gap: {{model: none.yaml, train: a, test: [b]}}\n")
    step = load_model(path, Campaign).steps[2]
    assert isinstance(step, GapStep)
    assert (step.train, step.test) == (("a",), ("b",))
    error = refusal(capsys, "run", path, "--out", tmp_path / "out")
    assert f"{path}:6: steps[2].gap.model: no such model file" in error
    assert not (tmp_path / "out").exists()


def gap_result(verdict: str = "named") -> GapResult:
    """Return an answer that names dry friction with an equivalent and an open question."""
    model = parse_model(yaml.safe_load(MODEL.read_text()))
    score = {"speed_rad_s": Score(rmse=0.1, nrmse=0.2, gap=0.2)}
    base = ResultStep(
        added=None, parameters={}, equivalents=(), where=(), evidence={}, train=score, test=score
    )
    level = {"level": Quantity(value=0.15, std=0.001, unit="N m")}
    step = replace(base, added="coulomb_friction", parameters=level, equivalents=(("a", "b"), "c"))
    return GapResult(
        verdict=verdict,
        effects=("coulomb_friction",),
        unknown=None,
        parameter_changes=(ParameterChange(parameter="inertia", nameplate=0.5, estimate=0.6, std=0.01),),
        gap_before=0.2,
        gap_after=0.01,
        noise_floor={"speed_rad_s": 0.01},
        steps=(base, step),
        next_experiment={
            "why": "separates a from b",
            "separates": ["a", "b"],
            "duration_s": 20.0,
            "excitation": {"kind": "sine", "amplitude_A": 0.5, "period_s": 2.0},
        },
        base_model=model,
        model=model,
        terms=(EffectTerm(id="coulomb_friction", parameters=level),),
    )


def test_the_answer_is_told_in_plain_words() -> None:
    analysis = GapAnalysis(result=gap_result(), folder=Path("o"), experiment=Path("o/next_campaign.yaml"))
    told = "\n".join(describe_gap(analysis))
    assert "+ coulomb_friction: level 0.1500 ± 0.0010 N m" in told
    assert "cannot tell it from: a with b (a together with b); c (c)" in told
    assert "inertia is 0.600 ± 0.010 kg m², not 0.5000 kg m² as on the nameplate" in told
    assert "speed: gap 0.0995 rad/s (20.0 % of the signal) before" in told
    assert "95.0 % of the gap is closed" in told
    assert "jointscope run o/next_campaign.yaml --rig RIG.yaml" in told


def test_a_pool_tells_nothing_in_its_first_seconds_and_takes_nothing_after_a_stop() -> None:
    from server.errors import CampaignStoppedError

    told: list[str] = []
    stop = Event()
    with WorkerPool(1, "math", told.append, stop) as pool:
        assert list(pool.map(abs, [-1, -2])) == [1, 2]
        stop.set()
        with pytest.raises(CampaignStoppedError, match="stopped while analysing"):
            pool.submit(abs, -3)
    assert told == []


POOL_OF_ONE = """
import os, threading, time
from server.services.workers import WorkerPool
if __name__ == "__main__":
    pool = WorkerPool(1, "math", print, threading.Event())
    print(pool.submit(os.getpid).result(), flush=True)
    pool.submit(time.sleep, 600).result()
"""


@pytest.mark.slow
def test_a_worker_ends_with_its_parent_when_that_is_killed(tmp_path: Path) -> None:
    script = tmp_path / "pool.py"
    script.write_text(POOL_OF_ONE)
    parent = subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True)
    assert parent.stdout is not None
    worker = int(parent.stdout.readline())
    parent.kill()
    parent.communicate()
    deadline_s = time.monotonic() + 30.0
    while runs(worker):
        assert time.monotonic() < deadline_s, f"process {worker} outlives its parent"
        Event().wait(0.05)


def runs(process: int) -> bool:
    """Say whether a process is there and not merely waiting to be collected."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
