"""Quantities in YAML: a bare number in the unit of its key, or text with a unit that is converted.

`amplitude_A: 0.4`, `amplitude_A: 0.4 A` and `amplitude_A: 400 mA` mean the same. A unit of another kind is
refused with the spellings that are allowed. Knows no file and no model.
"""

import re
from collections.abc import Mapping
from typing import Annotated

from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError

# For each unit used inside the program: the accepted spellings and what one of them is worth in it.
SPELLINGS: Mapping[str, Mapping[str, float]] = {
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0},
    "ms": {"ms": 1.0, "s": 1e3, "us": 1e-3},
    "A": {"A": 1.0, "mA": 1e-3, "uA": 1e-6},
    "A/s": {"A/s": 1.0, "mA/s": 1e-3, "A/ms": 1e3},
    "Hz": {"Hz": 1.0, "kHz": 1e3, "mHz": 1e-3},
    "Bd": {"Bd": 1.0, "kBd": 1e3, "MBd": 1e6},
    "rad": {"rad": 1.0, "deg": 0.017453292519943295, "turn": 6.283185307179586},
    "rad/s": {"rad/s": 1.0, "deg/s": 0.017453292519943295, "rpm": 0.10471975511965977},
    "kg m^2": {"kg m^2": 1.0, "g cm^2": 1e-7},
    "N m s/rad": {"N m s/rad": 1.0, "mN m s/rad": 1e-3},
    "N m/A": {"N m/A": 1.0, "mN m/A": 1e-3},
    "N m": {"N m": 1.0, "mN m": 1e-3},
}

_NUMBER_WITH_UNIT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")


def _normalise(unit: str) -> str:
    """Return the spelling used in `SPELLINGS`: `kg·m²` and `kg*m^2` are `kg m^2`."""
    return unit.replace("·", " ").replace("*", " ").replace("²", "^2").replace("µ", "u").replace("Ω", "Ohm")


def parse_quantity(value: object, unit: str) -> float:
    """Return a number in `unit` from a bare number or from text such as `400 mA`.

    Args:
        value: what stood in the YAML file.
        unit: a key of `SPELLINGS`.

    Raises:
        PydanticCustomError: not a number, or a unit of another kind.
    """
    allowed = ", ".join(SPELLINGS[unit])
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    match = _NUMBER_WITH_UNIT.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        raise PydanticCustomError(
            "quantity", "{value} is not a number in {unit}", {"value": repr(value), "unit": unit}
        )
    number, given = float(match[1]), _normalise(match[2])
    if not given:
        return number
    factor = SPELLINGS[unit].get(given)
    if factor is None:
        raise PydanticCustomError(
            "unit",
            "{value} is in {given}; allowed here: {allowed}",
            {"value": repr(value), "given": given, "allowed": allowed},
        )
    return number * factor


def _in(unit: str) -> BeforeValidator:
    return BeforeValidator(lambda value: parse_quantity(value, unit))


Seconds = Annotated[float, _in("s")]
Milliseconds = Annotated[float, _in("ms")]
Amperes = Annotated[float, _in("A")]
AmperesPerSecond = Annotated[float, _in("A/s")]
Hertz = Annotated[float, _in("Hz")]
Baud = Annotated[float, _in("Bd")]
Radians = Annotated[float, _in("rad")]
RadiansPerSecond = Annotated[float, _in("rad/s")]
KilogramSquareMetres = Annotated[float, _in("kg m^2")]
NewtonMetreSecondsPerRadian = Annotated[float, _in("N m s/rad")]
NewtonMetresPerAmpere = Annotated[float, _in("N m/A")]
