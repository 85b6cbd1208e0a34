"""Campaigns that come over the API: YAML or JSON text to plain values, and back to a file as `load_model` reads it."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from server.errors import InputError, InputLocation

MAX_OCTETS = 1_000_000
SOURCE = "request"


def read_document(body: bytes) -> str:
    """Return a submitted document as text.

    Raises:
        InputError: not UTF-8, or larger than a campaign ever is.
    """
    if len(body) > MAX_OCTETS:
        raise InputError(
            f"{len(body)} octets are too many; at most {MAX_OCTETS}", InputLocation(source=SOURCE)
        )
    try:
        return body.decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(f"is not UTF-8 text: {error}", InputLocation(source=SOURCE)) from error


def yaml_of_json(text: str) -> str:
    """Return JSON text as YAML: not all JSON numbers are numbers in YAML 1.1.

    Raises:
        InputError: not JSON.
    """
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"not valid JSON: {error}", InputLocation(source=SOURCE)) from error
    return dump(content)


def dump(content: Any) -> str:  # Any: JSON values
    """Return plain values as YAML text."""
    text: str = yaml.safe_dump(content, sort_keys=False, allow_unicode=True)
    return text


def write_document(path: Path, content: Mapping[str, Any]) -> Path:  # Any: JSON values
    """Write plain values as a YAML file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(dump(dict(content)), encoding="utf-8")
    return path
