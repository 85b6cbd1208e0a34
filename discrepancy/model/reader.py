"""Read and write model files (YAML). The only place of this package that knows YAML."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

import yaml

from discrepancy.errors import ModelFileError
from discrepancy.model.schema import EffectTerm, InputHold, JointModel, Judge, Quantity

_KEYS = {
    "name", "axis", "input", "outputs", "parameters", "effects", "judge_by", "input_hold", "version", "lineage",
}  # fmt: skip
_QUANTITY_KEYS = {"value", "unit", "std", "fixed"}
E = TypeVar("E", Judge, InputHold)


def read_model(path: Path) -> JointModel:
    """Read a model file.

    Raises:
        ModelFileError: a key or value is not allowed; the message names file and field.
    """
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
        return parse_model(data, path.stem)
    except yaml.YAMLError as error:
        raise ModelFileError(f"{path}: not readable as YAML: {error}") from error
    except OSError as error:
        raise ModelFileError(f"{path}: {error.strerror}") from error
    except ModelFileError as error:
        raise ModelFileError(f"{path}: {error}") from error


def parse_model(data: object, name: str = "joint") -> JointModel:
    """Make a model of the mapping that a model file holds."""
    if not isinstance(data, Mapping):
        raise ModelFileError("a model file is a mapping with the keys name, axis, input, outputs, parameters")
    for key in data:
        if key not in _KEYS:
            raise ModelFileError(f"{key}: unknown key; allowed are {', '.join(sorted(_KEYS))}")
    axis = data.get("axis", "rotary")
    if axis not in ("rotary", "linear"):
        raise ModelFileError(f"axis: {axis!r} is not allowed; write rotary or linear")
    outputs = data.get("outputs", ["speed_rad_s" if axis == "rotary" else "position_m"])
    if not isinstance(outputs, list) or not outputs or not all(isinstance(o, str) for o in outputs):
        raise ModelFileError("outputs: a list of at least one column name is needed")
    parameters = _mapping(data.get("parameters"), "parameters")
    return JointModel(
        name=str(data.get("name", name)),
        axis=axis,
        input=str(data.get("input", "current_A")),
        outputs=tuple(outputs),
        parameters={key: _quantity(value, f"parameters.{key}") for key, value in parameters.items()},
        effects=tuple(_term(item, i) for i, item in enumerate(data.get("effects") or [])),
        judge_by=_choice(Judge, data.get("judge_by", "simulation"), "judge_by"),
        input_hold=_choice(InputHold, data.get("input_hold", "auto"), "input_hold"),
        version=int(data.get("version", 1)),
        lineage=tuple(data.get("lineage") or ()),
    )


def _choice(enum: type[E], value: object, field: str) -> E:
    try:
        return enum(value)
    except ValueError:
        allowed = ", ".join(str(member.value) for member in enum)
        raise ModelFileError(f"{field}: {value!r} is not allowed; write one of {allowed}") from None


def _mapping(value: object, field: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise ModelFileError(f"{field}: a mapping of names to {{value, unit}} is needed")
    return value


def _quantity(value: object, field: str) -> Quantity:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return Quantity(value=float(value))
    entry = _mapping(value, field)
    for key in entry:
        if key not in _QUANTITY_KEYS:
            raise ModelFileError(
                f"{field}.{key}: unknown key; allowed are {', '.join(sorted(_QUANTITY_KEYS))}"
            )
    number = entry.get("value")
    if isinstance(number, bool) or not isinstance(number, (int, float)) or not abs(number) < 1e12:
        raise ModelFileError(f"{field}.value: {number!r} is not a finite number")
    std = entry.get("std")
    return Quantity(
        value=float(number),
        unit=str(entry.get("unit", "")),
        std=None if std is None else float(std),
        fixed=bool(entry.get("fixed", False)),
    )


def _term(item: object, index: int) -> EffectTerm:
    entry = _mapping(item, f"effects[{index}]")
    parameters = _mapping(entry.get("parameters") or {}, f"effects[{index}].parameters")
    return EffectTerm(
        id=str(entry.get("id")),
        parameters={name: _quantity(value, f"effects[{index}].{name}") for name, value in parameters.items()},
    )


def model_to_dict(model: JointModel) -> dict[str, Any]:
    """Return what `parse_model` reads back."""
    return {
        "name": model.name,
        "version": model.version,
        "axis": model.axis,
        "input": model.input,
        "outputs": list(model.outputs),
        "parameters": {name: quantity_to_dict(q) for name, q in model.parameters.items()},
        "effects": [
            {"id": term.id, "parameters": {n: quantity_to_dict(q) for n, q in term.parameters.items()}}
            for term in model.effects
        ],
        "judge_by": model.judge_by.value,
        "input_hold": model.input_hold.value,
        "lineage": [dict(entry) for entry in model.lineage],
    }


def quantity_to_dict(quantity: Quantity) -> dict[str, Any]:
    """Return a quantity as a mapping, without what is not known."""
    entry: dict[str, Any] = {"value": quantity.value}
    if quantity.std is not None:
        entry["std"] = quantity.std
    if quantity.unit:
        entry["unit"] = quantity.unit
    if quantity.fixed:
        entry["fixed"] = True
    return entry


def write_model(model: JointModel, path: Path) -> None:
    """Write a model file that `read_model` accepts."""
    text = yaml.safe_dump(model_to_dict(model), sort_keys=False, allow_unicode=True)
    path.write_text(text, encoding="utf-8")
