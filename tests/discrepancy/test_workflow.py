"""The whole chain on joints whose answer is known."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest

from daq.recording.recording import Recording, recording_from_columns
from discrepancy.errors import GapInputError
from discrepancy.model.reader import read_model
from discrepancy.model.schema import JointModel
from discrepancy.report.files import write_result
from discrepancy.simulation import slots as s
from discrepancy.workflow import run_gap

Recorder = Callable[[Mapping[int, float], int], Recording]

COULOMB = {s.COULOMB: 0.12}


@pytest.mark.slow
def test_coulomb_friction_is_named_with_its_level(nameplate: JointModel, record: Recorder) -> None:
    result = run_gap(nameplate, [record(COULOMB, 1), record(COULOMB, 2)], [record(COULOMB, 11)])
    assert result.effects == ("coulomb_friction",)
    level = result.terms[0].parameters["level"]
    assert level.std is not None
    # Five standard errors: the truth is the package's own kernel, nothing but noise may part them.
    assert abs(level.value - 0.12) < 5.0 * level.std + 1e-3


@pytest.mark.slow
def test_nothing_hidden_gives_none_and_corrects_the_nameplate(
    nameplate: JointModel, record: Recorder
) -> None:
    result = run_gap(nameplate, [record({}, 1), record({}, 2)], [record({}, 11)])
    assert (result.verdict, result.effects, result.gap_closed) == ("none", (), None)
    assert {change.parameter for change in result.parameter_changes} == {
        "viscous_friction",
        "torque_constant",
    }


@pytest.mark.slow
def test_answer_files_hold_the_contract_and_the_model_reads_back(
    nameplate: JointModel, record: Recorder, tmp_path: Path
) -> None:
    result = run_gap(nameplate, [record(COULOMB, 1)], [record(COULOMB, 11)])
    write_result(result, tmp_path)
    answer = json.loads((tmp_path / "gap.json").read_text(encoding="utf-8"))
    assert answer["schema"] == "jointscope.gap/1"
    assert answer["steps"][0]["added"] is None
    assert answer["steps"][1]["outputs"]["speed_rad_s"]["test"].keys() == {"rmse", "nrmse", "gap"}
    assert read_model(tmp_path / "model.yaml").effects[0].id == "coulomb_friction"
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "The model lacks dry (Coulomb) friction" in page
    assert "https://cdn" not in page.split("<script", 1)[0]


def test_equal_test_and_training_record_is_refused(nameplate: JointModel, record: Recorder) -> None:
    same = record({}, 1)
    with pytest.raises(GapInputError, match="must not have been used for training"):
        run_gap(nameplate, [same], [same])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("constant", "is constant"),
        ("rest", "does not change|does not answer"),
        ("short", "too few"),
        ("backwards", "does not rise"),
        ("column", "is missing"),
    ],
)
def test_records_that_cannot_answer_are_refused(
    change: str, message: str, nameplate: JointModel, record: Recorder
) -> None:
    columns = {name: np.array(record({}, 1).column(name)) for name in ("time_s", "current_A", "speed_rad_s")}
    if change == "constant":
        columns["current_A"][:] = 0.3
    elif change == "rest":
        columns["speed_rad_s"] = np.random.default_rng(0).normal(0.0, 1e-3, columns["time_s"].size)
    elif change == "short":
        columns = {name: values[:200] for name, values in columns.items()}
    elif change == "backwards":
        columns["time_s"][100:] -= 1.0
    else:
        columns["other_A"] = columns.pop("speed_rad_s")
    broken = recording_from_columns(columns, sample_time_s=2e-3)
    with pytest.raises(GapInputError, match=message):
        run_gap(nameplate, [broken], [record({}, 11)])
