"""Runner and scorer of the blind benchmark, with a solver that always answers `none`."""

import json
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from benchmarks.blind.conditions import Case
from benchmarks.blind.figures import gap_shrink, parameter_errors
from benchmarks.blind.question import Answer, Question, read_question, write_answer, write_question
from benchmarks.blind.run import answer_path, verdict_path, write_plan
from benchmarks.blind.score import read_condition
from benchmarks.blind.solve import whole
from benchmarks.blind.tables import condition_table, figure_table, id_table

SOLVER = "tests.benchmarks.answer_nothing"
ROOT = Path(__file__).resolve().parents[2]


def play(out: Path, *more: str) -> str:
    command = [sys.executable, "-m", "benchmarks.blind.run", str(out), "--set", "development", "--jobs", "1"]
    done = subprocess.run(
        [*command, "--condition", "full", "--count", "1", "--ids", "load_torque_offset,torque_ripple", *more],
        capture_output=True, text=True, check=True, timeout=120, cwd=ROOT,
    )  # fmt: skip
    return done.stdout


@pytest.mark.slow
def test_cases_are_made_solved_apart_and_scored(tmp_path: Path) -> None:
    assert "2 of 2" in play(tmp_path, "--solver", SOLVER)
    solved = list(read_condition(tmp_path / "full", partial=False))
    assert [one.answer.hidden for one in solved] == [["load_torque_offset"], ["torque_ripple"]]
    assert [one.worth.value for one in solved] == ["miss", "miss"]
    assert not list((tmp_path / "full" / "questions").iterdir())


@pytest.mark.slow
def test_a_run_out_of_time_is_resumed_and_its_answers_stay_closed_until_then(tmp_path: Path) -> None:
    assert "0 of 2" in play(tmp_path, "--solver", SOLVER, "--limit", "0")
    with pytest.raises(SystemExit, match="2 of 2 cases have no verdict"):
        list(read_condition(tmp_path / "full", partial=False))
    assert "2 of 2" in play(tmp_path, "--solver", SOLVER)


@pytest.mark.slow
def test_a_solver_that_dies_has_failed_the_case(tmp_path: Path) -> None:
    play(tmp_path, "--solver", "tests.benchmarks.no_such_solver")
    solved = list(read_condition(tmp_path / "full", partial=False))
    assert [(one.verdict, one.worth.value) for one in solved] == [("failed", "miss")] * 2


def test_one_folder_does_not_mix_development_and_scoring(tmp_path: Path) -> None:
    case = Case(condition="full", id="backlash", seed=1)
    write_plan(tmp_path, [case], "development")
    with pytest.raises(ValueError, match="holds development cases"):
        write_plan(tmp_path, [case], "scoring")


def test_an_unfinished_scoring_run_is_not_opened_even_in_part(tmp_path: Path) -> None:
    write_plan(tmp_path, [Case(condition="full", id="backlash", seed=1)], "scoring")
    with pytest.raises(SystemExit, match="stay closed"):
        list(read_condition(tmp_path / "full", partial=True))


def test_a_question_is_read_as_it_was_written(tmp_path: Path) -> None:
    asked = Question(model={"name": "x"}, step_s=1e-3, records={"train0": {"time_s": np.arange(3.0)}})
    write_question(asked, tmp_path)
    read = read_question(tmp_path)
    assert (read.model, read.step_s, list(read.records)) == (asked.model, asked.step_s, ["train0"])
    assert np.array_equal(read.records["train0"]["time_s"], np.arange(3.0))


def named(effect: str, **parameters: tuple[float, float]) -> dict[str, object]:
    """Return a verdict that names one effect: parameter = (value, std)."""
    terms = [{"id": effect, "parameters": {k: {"value": v, "std": s} for k, (v, s) in parameters.items()}}]
    return {
        "verdict": "named",
        "steps": [{"added": None, "equivalents": []}, {"added": effect, "equivalents": []}],
        "extended": terms,
        "wall_seconds": 2.0,
        "cpu_seconds": 1.0,
        "order_in_worker": 1,
    }


def hidden(effect: str, **truth: float) -> Answer:
    return Answer(
        condition="full",
        id=effect,
        seed=1,
        hidden=[effect],
        scenario=[],
        truth={effect: truth},
        gap={effect: 2.0},
    )


def test_parameter_errors_are_relative_and_intervals_are_95_percent() -> None:
    errors, covered = parameter_errors(
        hidden("coulomb_friction", level=0.2), named("coulomb_friction", level=(0.21, 0.004))
    )
    assert errors["coulomb_friction.level"] == pytest.approx(0.05)
    assert covered == {"coulomb_friction.level": False}


def test_the_parts_of_a_wave_err_relative_to_its_amplitude() -> None:
    errors, covered = parameter_errors(
        hidden("torque_ripple", sine=0.3, cosine=0.4, with_current=0.0),
        named("torque_ripple", sine=(0.35, 0.1), cosine=(0.4, 0.1), with_current=(0.0, 0.0)),
    )
    assert errors == pytest.approx({"torque_ripple.sine": 0.1, "torque_ripple.cosine": 0.0})
    assert all(covered.values())


def test_the_gap_shrinks_by_the_ratio_of_distances_to_the_noise_free_output(tmp_path: Path) -> None:
    clean = np.sin(np.arange(100.0))
    path = tmp_path / "x.npz"
    np.savez(path, before=clean + 0.2, after=clean - 0.01)
    assert gap_shrink(hidden("coulomb_friction"), clean, path) == pytest.approx(20.0)


def test_an_answer_without_the_ends_of_the_record_is_judged_between_them(tmp_path: Path) -> None:
    clean = np.sin(np.arange(100.0))
    path = tmp_path / "x.npz"
    inner = clean[5:-5]
    np.savez(path, before=whole(inner + 0.2, clean.size), after=whole(inner - 0.01, clean.size))
    assert gap_shrink(hidden("coulomb_friction"), clean, path) == pytest.approx(20.0)


def test_play_is_judged_in_windows(tmp_path: Path) -> None:
    clean = np.zeros(10)
    path = tmp_path / "x.npz"
    windows = {"before_windows": clean + 0.3, "after_windows": np.append(clean[1:] + 0.1, np.nan)}
    np.savez(path, before=clean + 9.0, after=clean + 9.0, **windows)  # type: ignore[arg-type]  # any array
    assert gap_shrink(hidden("backlash"), clean, path) == pytest.approx(3.0)


def test_the_tables_show_what_was_counted(tmp_path: Path) -> None:
    case = Case(condition="full", id="coulomb_friction", seed=1)
    write_plan(tmp_path, [case], "scoring")
    write_answer(hidden("coulomb_friction", level=0.2), np.zeros(100), 4e-3, answer_path(tmp_path, case))
    path = verdict_path(tmp_path, case)
    path.parent.mkdir(parents=True)
    path.with_suffix(".json").write_text(json.dumps(named("coulomb_friction", level=(0.201, 0.001))))
    np.savez(path.with_suffix(".npz"), before=np.full(100, 0.6), after=np.full(100, 0.02))
    solved = {"full": list(read_condition(tmp_path / "full", partial=False))}
    assert "1/1 = 100.0% (20.7% to 100.0%)" in condition_table(solved)[2]
    assert "| full | 30.0 | 30.0 | 0.50% | 1/1 = 100.0% (20.7% to 100.0%) | 2.0 s" in figure_table(solved)[2]
    assert "| full | coulomb_friction | 1/1" in id_table(solved)[2]


def test_an_answer_is_read_as_it_was_written(tmp_path: Path) -> None:
    written = hidden("coulomb_friction", level=0.2)
    write_answer(written, np.arange(20.0), 1e-3, tmp_path / "a")
    content = json.loads((tmp_path / "a.json").read_text())
    assert content == asdict(written)
