"""Values of a model file, checked one by one: each refusal names the field, the value and the remedy."""

import math
import re
from collections.abc import Mapping
from enum import Enum
from typing import Any, TypeVar

from discrepancy.errors import ModelFileError
from discrepancy.model.schema import Quantity

E = TypeVar("E", bound=Enum)
LARGEST = 1e12
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_QUANTITY_KEYS = ("value", "unit", "std", "fixed")
# Parts of units that are not SI; the values of a model file are taken in SI whatever the unit says.
_FOREIGN = frozenset(
    [
        "mN",
        "kN",
        "mNm",
        "Ncm",
        "Nmm",
        "mA",
        "mV",
        "g",
        "t",
        "mm",
        "cm",
        "um",
        "gcm",
        "kgcm",
        "kgf",
        "lb",
        "lbf",
    ]
    + [
        "oz",
        "ozf",
        "in",
        "ft",
        "deg",
        "degree",
        "degrees",
        "rev",
        "rpm",
        "krpm",
        "rps",
        "min",
        "h",
        "ms",
        "us",
    ]
)
_SHOWN = 60


def show(value: object) -> str:
    """Return a value for a message, cut where it is long."""
    try:
        text = repr(value)
    except (RecursionError, ValueError):  # a list that holds itself; an integer of thousands of digits
        text = f"a {type(value).__name__}"
    return text if len(text) <= _SHOWN else text[: _SHOWN - 3] + "..."


def mapping(
    value: object, field: str, what: str, allowed: tuple[str, ...] | None = None
) -> Mapping[str, Any]:
    """Return a mapping whose keys are names, and among the allowed ones."""
    if not isinstance(value, Mapping):
        raise ModelFileError(f"{field}: {show(value)} is not allowed; {what} is needed")
    for key in value:
        if not isinstance(key, str):
            raise ModelFileError(f"{field}: the key {show(key)} is not a name; {what} is needed")
        if allowed is not None and key not in allowed:
            where = f"{field}.{key}" if field else key
            raise ModelFileError(f"{where}: unknown key; allowed are {', '.join(sorted(allowed))}")
    return value


def text(value: object, field: str) -> str:
    """Return a text that is not empty; a bare number counts as its digits."""
    if isinstance(value, bool) or not isinstance(value, (str, int, float)) or not str(value).strip():
        raise ModelFileError(f"{field}: {show(value)} is not a text; write a name")
    return str(value)


def number(value: object, field: str) -> float:
    """Return a finite number; `5e-4` counts, though YAML 1.1 takes it for a text."""
    if isinstance(value, str) and _NUMBER.fullmatch(value.strip()):
        value = float(value)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < LARGEST:
        raise ModelFileError(
            f"{field}: {show(value)} is not a finite number below {LARGEST:g}; write one in SI units, such as 5.0e-4"
        )
    return float(value)


def flag(value: object, field: str) -> bool:
    """Return a truth value."""
    if not isinstance(value, bool):
        raise ModelFileError(f"{field}: {show(value)} is not allowed; write true or false")
    return value


def choice(enum: type[E], value: object, field: str) -> E:
    """Return the member with this value."""
    for member in enum:
        if isinstance(value, str) and value == member.value:
            return member
    allowed = ", ".join(str(member.value) for member in enum)
    raise ModelFileError(f"{field}: {show(value)} is not allowed; write one of {allowed}")


def quantity(value: object, field: str) -> Quantity:
    """Return a parameter: a bare number, or a mapping of value, unit, std and fixed."""
    if not isinstance(value, Mapping):
        return Quantity(value=number(value, field))
    entry = mapping(value, field, "a number or a mapping {value, unit}", _QUANTITY_KEYS)
    if "value" not in entry:
        raise ModelFileError(f"{field}.value: is missing; give the nameplate value in SI units")
    std = None if entry.get("std") is None else number(entry["std"], f"{field}.std")
    if std is not None and std < 0.0:
        raise ModelFileError(f"{field}.std: {std:g} is not allowed; a standard error is 0 or larger")
    return Quantity(
        value=number(entry["value"], f"{field}.value"),
        unit=_unit(entry.get("unit"), f"{field}.unit"),
        std=std,
        fixed=flag(entry.get("fixed", False), f"{field}.fixed"),
    )


def _unit(value: object, field: str) -> str:
    """Return the unit, which only tells the reader: values are taken in SI."""
    if value is None or value == "":
        return ""
    unit = text(value, field)
    foreign = [part for part in re.findall(r"[^\W\d_]+", unit) if part in _FOREIGN]
    if foreign or "°" in unit:
        raise ModelFileError(
            f"{field}: {show(unit)} is not SI ({(foreign or ['°'])[0]}), and values are taken in SI; convert the value "
            "to kg, m, s, A, N, rad and write that unit"
        )
    return unit


def positive(quantity: Quantity, field: str, *, zero: bool) -> None:
    """Refuse a parameter with the wrong sign."""
    if quantity.value > 0.0 or (zero and quantity.value == 0.0):
        return
    limit = "0 or larger" if zero else "larger than 0"
    hint = "" if zero else "; where the joint turns the other way, turn the sign of the current's column"
    raise ModelFileError(f"{field}.value: {quantity.value:g} is not allowed; it must be {limit}{hint}")


def whole(value: object, field: str) -> int:
    """Return a whole number from 1 on."""
    found = number(value, field)
    if not (math.isfinite(found) and found == int(found) and found >= 1.0):
        raise ModelFileError(f"{field}: {show(value)} is not allowed; write a whole number from 1 on")
    return int(found)
