"""Read and write model files (YAML). The only place of this package that knows YAML."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from discrepancy.effects.table import EFFECTS
from discrepancy.errors import ModelFileError
from discrepancy.model import fields
from discrepancy.model.schema import BASE_SLOTS, EffectTerm, InputHold, JointModel, Judge, Quantity
from discrepancy.simulation import slots as s

_KEYS = (
    "name", "axis", "input", "outputs", "parameters", "effects", "judge_by", "input_hold", "version", "lineage",
)  # fmt: skip
_WHOLE = "a mapping with the keys name, axis, input, outputs, parameters"


def read_model(path: Path) -> JointModel:
    """Read a model file.

    Raises:
        ModelFileError: a key or value is not allowed; the message names file, field, value and remedy.
    """
    try:
        content = path.read_text(encoding="utf-8-sig")
        _refuse_twice(yaml.compose(content, yaml.SafeLoader))
        return parse_model(yaml.safe_load(content), path.stem)
    except ModelFileError as error:
        raise ModelFileError(f"{path}: {error}") from error
    except UnicodeDecodeError as error:
        raise ModelFileError(f"{path}: not a text file in UTF-8; save it as such") from error
    except OSError as error:
        raise ModelFileError(f"{path}: {error.strerror}") from error
    except RecursionError as error:
        raise ModelFileError(f"{path}: nested too deeply; a model file is {_WHOLE}") from error
    except (yaml.YAMLError, ValueError, TypeError, OverflowError) as error:  # such as a date on 31 February
        raise ModelFileError(f"{path}: not readable as YAML: {' '.join(str(error).split())}") from error


def parse_model(data: object, name: str = "joint") -> JointModel:
    """Make a model of the mapping that a model file holds.

    Raises:
        ModelFileError: a key or value is not allowed; the message names field, value and remedy.
    """
    if not isinstance(data, Mapping):
        raise ModelFileError(f"{fields.show(data)} is not allowed; a model file is {_WHOLE}")
    entry = fields.mapping(data, "", _WHOLE, _KEYS)
    axis = entry.get("axis", "rotary")
    if axis not in ("rotary", "linear"):
        raise ModelFileError(f"axis: {fields.show(axis)} is not allowed; write rotary or linear")
    return JointModel(
        name=fields.text(entry.get("name", name), "name"),
        axis=axis,
        input=fields.text(entry.get("input", "current_A"), "input"),
        outputs=_outputs(entry.get("outputs", ["speed_rad_s" if axis == "rotary" else "position_m"])),
        parameters=_parameters(entry.get("parameters")),
        effects=tuple(_term(item, f"effects[{i}]") for i, item in enumerate(_list(entry, "effects"))),
        judge_by=fields.choice(Judge, entry.get("judge_by", "simulation"), "judge_by"),
        input_hold=fields.choice(InputHold, entry.get("input_hold", "auto"), "input_hold"),
        version=fields.whole(entry.get("version", 1), "version"),
        lineage=tuple(
            fields.mapping(item, f"lineage[{i}]", "a mapping that tells of an earlier version")
            for i, item in enumerate(_list(entry, "lineage"))
        ),
    )


def _refuse_twice(root: yaml.Node | None) -> None:
    """Refuse a key that stands twice in one mapping: YAML would silently take the last one."""
    for node in _nodes(root):
        seen = set()
        for key, _ in node.value if isinstance(node, yaml.MappingNode) else ():
            if isinstance(key, yaml.ScalarNode) and key.value in seen:
                raise ModelFileError(
                    f"line {key.start_mark.line + 1}: the key {fields.show(key.value)} stands twice; remove one of them"
                )
            seen.add(key.value if isinstance(key, yaml.ScalarNode) else id(key))


def _nodes(root: yaml.Node | None) -> Iterator[yaml.Node]:
    waiting, seen = [root], set()
    while waiting:
        node = waiting.pop()
        if node is None or id(node) in seen:  # an anchor may lead back to where it is used
            continue
        seen.add(id(node))
        yield node
        if isinstance(node, yaml.MappingNode):
            waiting.extend(part for pair in node.value for part in pair)
        elif isinstance(node, yaml.SequenceNode):
            waiting.extend(node.value)


def _list(entry: Mapping[str, Any], field: str) -> list[object]:
    value = entry.get(field)
    if value is None:
        return []
    if not isinstance(value, (list, tuple)):
        raise ModelFileError(f"{field}: {fields.show(value)} is not allowed; a list is needed, [] for none")
    return list(value)


def _outputs(value: object) -> tuple[str, ...]:
    if not isinstance(value, (list, tuple)) or not value or not all(isinstance(o, str) and o for o in value):
        raise ModelFileError(
            f"outputs: {fields.show(value)} is not allowed; a list of at least one column name is needed, such as "
            "[speed_rad_s]"
        )
    for name in value:
        if value.count(name) > 1:
            raise ModelFileError(f"outputs: {fields.show(name)} stands twice; remove one of them")
    return tuple(value)


def _parameters(value: object) -> dict[str, Quantity]:
    entry = fields.mapping(value, "parameters", "a mapping of names to {value, unit}")
    found = {key: fields.quantity(item, f"parameters.{key}") for key, item in entry.items()}
    owners: dict[int, str] = {}
    for key, one in found.items():
        slot = BASE_SLOTS.get(key)  # an unknown name is refused by the model itself
        if slot is None:
            continue
        fields.positive(one, f"parameters.{key}", zero=slot == s.VISCOUS)
        if slot in owners:
            raise ModelFileError(
                f"parameters.{key}: is the same number as {owners[slot]}; give one of them, by the kind of the axis"
            )
        owners[slot] = key
    return found


def _term(item: object, field: str) -> EffectTerm:
    entry = fields.mapping(item, field, "a mapping {id, parameters}", ("id", "parameters"))
    if not isinstance(entry.get("id"), str):
        raise ModelFileError(
            f"{field}.id: {fields.show(entry.get('id'))} is not the id of an effect; docs/effects.md lists them"
        )
    inner = entry.get("parameters")
    parameters = fields.mapping(
        {} if inner is None else inner, f"{field}.parameters", "a mapping of names to {value, unit}"
    )
    term = EffectTerm(
        id=entry["id"],
        parameters={
            name: fields.quantity(value, f"{field}.parameters.{name}") for name, value in parameters.items()
        },
    )
    known = (
        {parameter.name: parameter for parameter in EFFECTS[term.id].parameters} if term.id in EFFECTS else {}
    )
    for name, one in term.parameters.items():
        if name in known and known[name].lower >= 0.0:
            fields.positive(one, f"{field}.parameters.{name}", zero=True)
    return term


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
