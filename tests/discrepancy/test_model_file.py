"""Model files: what is read, what is refused."""

from pathlib import Path

import pytest

from discrepancy.errors import ModelFileError
from discrepancy.model.reader import model_to_dict, parse_model, read_model, write_model

MODEL = {
    "name": "joint1",
    "input": "current_A",
    "outputs": ["speed_rad_s"],
    "parameters": {"inertia": {"value": 5e-4, "unit": "kg m^2", "fixed": True}, "viscous_friction": 5.65e-4},
    "effects": [
        {"id": "coulomb_friction", "parameters": {"level": {"value": 0.1, "std": 0.01, "unit": "N m"}}}
    ],
}


def test_a_written_model_reads_back_equal(tmp_path: Path) -> None:
    model = parse_model(MODEL)
    write_model(model, tmp_path / "model.yaml")
    assert model_to_dict(read_model(tmp_path / "model.yaml")) == model_to_dict(model)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"axes": "rotary"}, "axes: unknown key"),
        ({"axis": "spherical"}, "axis: 'spherical'"),
        ({"judge_by": "eye"}, "judge_by: 'eye'"),
        ({"parameters": {"viscous_friction": 1.0}}, "inertia"),
        ({"parameters": {"inertia": {"value": "heavy"}}}, "parameters.inertia.value"),
        ({"effects": [{"id": "ghost"}]}, "'ghost' is not in the catalogue"),
    ],
)
def test_a_wrong_field_is_named(change: dict[str, object], message: str) -> None:
    with pytest.raises(ModelFileError, match=message):
        parse_model({**MODEL, **change})
