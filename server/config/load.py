"""Read one YAML file into one model; every error names file, line, field, value and what is allowed.

Only the safe loader is used. Duplicate keys, which YAML forbids and PyYAML accepts, are refused.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar

import yaml
from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from server.config.model import suggest
from server.errors import InputError, InputLocation

Model = TypeVar("Model", bound=BaseModel)
Loc = tuple[int | str, ...]


def load_model(path: Path, model: type[Model]) -> Model:
    """Return the file's content as a checked model.

    Raises:
        InputError: unreadable file, malformed YAML, or a key or value that the model does not allow.
    """
    document = _compose(path, _read_text(path))
    _refuse_duplicates(path, document)
    content = _construct(path, document)
    try:
        return model.model_validate(content)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        loc: Loc = first["loc"]
        if first["type"] == "unknown_key":
            loc = (*loc, first["ctx"]["key"])
        elif first["type"] == "rule_at":
            loc = first["ctx"]["at"]
        raise InputError(_phrase(first), locate(path, document, loc)) from error


def locate_field(path: Path, loc: Loc) -> InputLocation:
    """Return file, line and name of a field of a file that loaded without error."""
    return locate(path, _compose(path, _read_text(path)), loc)


def locate(path: Path, document: yaml.Node, loc: Loc) -> InputLocation:
    """Return where `loc` stands, following the document and leaving out union tags that are not in it."""
    node, names = document, ""
    for index, part in enumerate(loc):
        child = _child(node, part)
        if child is None and index < len(loc) - 1:
            continue
        names += f"[{part}]" if isinstance(part, int) else f".{part}"
        node = child or node
    return InputLocation(source=path, line=node.start_mark.line + 1, field=names.lstrip(".") or None)


def _read_text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        others = [entry.name for entry in path.parent.glob("*.yaml")] if path.parent.is_dir() else []
        raise InputError(f"no such file{suggest(path.name, others)}", InputLocation(source=path)) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot be read as UTF-8 text: {error}", InputLocation(source=path)) from error


def _compose(path: Path, text: str) -> yaml.Node:
    try:
        document = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.YAMLError as error:
        raise _invalid(path, error) from error
    if not isinstance(document, yaml.MappingNode):
        raise InputError("must hold keys and values (a YAML mapping)", InputLocation(source=path))
    return document


def _construct(path: Path, document: yaml.Node) -> object:
    try:
        return yaml.SafeLoader("").construct_document(document)
    except (yaml.YAMLError, ValueError) as error:  # ValueError: a date that is none
        raise _invalid(path, error) from error


def _invalid(path: Path, error: Exception) -> InputError:
    mark = getattr(error, "problem_mark", None)
    text = getattr(error, "problem", None) or getattr(error, "context", None) or error
    line = mark.line + 1 if mark else None
    return InputError(f"not valid YAML: {text}", InputLocation(source=path, line=line))


def _refuse_duplicates(path: Path, node: yaml.Node) -> None:
    children: Sequence[yaml.Node] = []
    if isinstance(node, yaml.MappingNode):
        seen: set[str] = set()
        for key, _ in node.value:
            if key.value in seen:
                location = InputLocation(source=path, line=key.start_mark.line + 1, field=str(key.value))
                raise InputError("this key stands twice; keep one", location)
            seen.add(key.value)
        children = [value for _, value in node.value]
    elif isinstance(node, yaml.SequenceNode):
        children = node.value
    for child in children:
        _refuse_duplicates(path, child)


def _child(node: yaml.Node, part: int | str) -> yaml.Node | None:
    if isinstance(node, yaml.SequenceNode) and isinstance(part, int):
        items: list[yaml.Node] = node.value
        return items[part] if part < len(items) else None
    if isinstance(node, yaml.MappingNode):
        return next((value for key, value in node.value if key.value == str(part)), None)
    return None


def _phrase(error: ErrorDetails) -> str:
    """Return pydantic's error in the words that this project uses: value first, then what is allowed."""
    kind, message = error["type"], error["msg"]
    if kind == "missing":
        return "this key is required and missing"
    if kind == "union_tag_not_found":
        return f"the key {error['ctx']['discriminator']} is required and missing"
    if kind == "union_tag_invalid":
        tag, tags = error["ctx"]["tag"], error["ctx"]["expected_tags"].replace("'", "")
        return f'"{tag}" is not known{suggest(tag, tags.split(", ")) or ";"} allowed: {tags}'
    if kind in ("unknown_key", "quantity", "unit", "rule", "rule_at"):
        return message
    return f"{error['input']!r} {message.replace('Input should be', 'must be')}"
