"""Model files: what is read, what is refused."""

from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

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
        ({"effects": 5}, "effects: 5 is not allowed; a list"),
        ({"effects": [{"id": ["x"]}]}, r"effects\[0\].id: \['x'\] is not the id of an effect"),
        ({"effects": [{"id": "coulomb_friction"}] * 2}, "'coulomb_friction' stands twice"),
        (
            {"effects": [{"id": "coulomb_friction", "parameters": {"level": -1}}]},
            "level.value: -1 is not allowed",
        ),
        ({"version": "new"}, "version: 'new' is not a finite number"),
        ({"version": 1.5}, "version: 1.5 is not allowed; write a whole number"),
        ({"lineage": 3}, "lineage: 3 is not allowed"),
        ({"lineage": [3]}, r"lineage\[0\]: 3 is not allowed"),
        ({"judge_by": ["torque"]}, r"judge_by: \['torque'\] is not allowed"),
        ({"outputs": ["speed_rad_s", "speed_rad_s"]}, "'speed_rad_s' stands twice"),
        ({"input": {"a": 1}}, "input: .* is not a text"),
        ({"parameters": {"inertia": None}}, "parameters.inertia: None is not a finite number"),
        ({"parameters": {"inertia": float("nan")}}, "parameters.inertia: nan is not a finite number"),
        ({"parameters": {"inertia": 10**400}}, "parameters.inertia: 1000.* is not a finite number"),
        ({"parameters": {"inertia": 0}}, "inertia.value: 0 is not allowed; it must be larger than 0"),
        ({"parameters": {"inertia": 1, "torque_constant": -1}}, "turn the sign of the current's column"),
        ({"parameters": {"inertia": 1, "mass": 1}}, "parameters.mass: is the same number as inertia"),
        ({"parameters": {"inertia": {"unit": "kg m^2"}}}, "inertia.value: is missing"),
        ({"parameters": {"inertia": {"value": 5, "unit": "g cm^2"}}}, "'g cm.2' is not SI .g."),
        (
            {"parameters": {"inertia": {"value": 5, "fixed": "no"}}},
            "inertia.fixed: 'no' is not allowed; write true",
        ),
        (
            {"parameters": {"inertia": {"value": 5, "std": "wide"}}},
            "inertia.std: 'wide' is not a finite number",
        ),
        ({"parameters": {"inertia": {"value": 5, "std": -1}}}, "inertia.std: -1 is not allowed"),
        ({"parameters": {1: 2}}, "parameters: the key 1 is not a name"),
    ],
)
def test_a_wrong_field_is_named(change: dict[str, object], message: str) -> None:
    with pytest.raises(ModelFileError, match=message):
        parse_model({**MODEL, **change})


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"name: \xff\xfe", "not a text file in UTF-8"),
        (b"name: [", "not readable as YAML"),
        (b"name: 2001-02-31", "not readable as YAML: day"),
        (b"parameters: {inertia: 1}\nname: a\nname: b\n", "line 3: the key 'name' stands twice"),
        (b"parameters: {inertia: 1, inertia: 2}", "line 1: the key 'inertia' stands twice"),
        (b"? [1, 2]\n: 3", "the key .* is not a name|not readable as YAML"),
        (b"outputs: &a [*a]", "outputs: .* is not allowed"),
        (b"[" * 3000, "nested too deeply|not readable as YAML"),
        (b"", "None is not allowed; a model file is a mapping"),
    ],
)
def test_a_file_that_is_no_model_is_named_with_its_reason(
    content: bytes, message: str, tmp_path: Path
) -> None:
    path = tmp_path / "model.yaml"
    path.write_bytes(content)
    with pytest.raises(ModelFileError, match=message) as caught:
        read_model(path)
    assert str(caught.value).startswith(f"{path}: ")


def test_a_number_without_a_point_before_its_exponent_is_a_number(tmp_path: Path) -> None:
    path = tmp_path / "model.yaml"
    path.write_text("parameters: {inertia: 5e-4}\n")  # YAML 1.1 reads the text "5e-4"
    assert read_model(path).parameters["inertia"].value == 5e-4


LEAF = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=6)
    | st.dates()
    | st.binary(max_size=4)
)
WORDS = st.sampled_from(
    ["value", "unit", "std", "fixed", "id", "parameters", "level", "inertia", "mass",
     "viscous_friction"]
) | st.integers() | st.text(max_size=4)  # fmt: skip
TREE = st.recursive(
    LEAF, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(WORDS, inner, max_size=3), max_leaves=8
)
FIELD = st.sampled_from([*MODEL, "axis", "judge_by", "input_hold", "version", "lineage"])


@given(st.dictionaries(FIELD, TREE, min_size=1, max_size=3))
def test_whatever_stands_in_a_field_is_read_or_refused_with_a_word(change: dict[str, object]) -> None:
    try:
        model = parse_model({**MODEL, **change})
    except ModelFileError as error:
        assert str(error).split(":")[0].split("[")[0].split(".")[0] in (*MODEL, *change)
        return
    assert model_to_dict(parse_model(model_to_dict(model))) == model_to_dict(model)


@given(TREE | st.dictionaries(WORDS, TREE))
def test_whatever_a_file_holds_only_a_model_file_error_comes_out(data: object) -> None:
    with pytest.raises(ModelFileError):
        parse_model(data)


@given(
    st.binary(max_size=60) | st.text(alphabet="[]{}:,-&*!|>#%@`'\"? \nab01.e", max_size=40).map(str.encode)
)
def test_whatever_the_bytes_are_only_a_model_file_error_comes_out(
    tmp_path_factory: pytest.TempPathFactory, content: bytes
) -> None:
    path = tmp_path_factory.mktemp("odd") / "model.yaml"
    path.write_bytes(content)
    with pytest.raises(ModelFileError, match="model.yaml: "):
        read_model(path)


def test_the_commented_model_file_is_read() -> None:
    path = Path(__file__).resolve().parents[2] / "config" / "models" / "joint1.yaml"
    assert model_to_dict(read_model(path))["parameters"] == yaml.safe_load(path.read_text())["parameters"]
