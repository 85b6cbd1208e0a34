"""`--map` in words and records: which column of a foreign file becomes which of ours, and its unit.

Three forms: `current_A=i` takes `i` as it is, `current_A=i*0.001` multiplies, `current_A=i[mA]` converts from
a unit.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from daq.errors import RecordingError
from daq.recording.units import CONVERSIONS, known_suffixes, known_units, stated_unit, unit_of

_FORM: Final = re.compile(
    r"^(?P<name>[^=\s]+)\s*=\s*(?P<source>.+?)\s*(?:\*\s*(?P<factor>[^*\s\[\]]+)|\[(?P<unit>[^\]]+)\])?$"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnMapping:
    """One column of a foreign file taken into a recording: `name` = `source` * `factor`.

    Attributes:
        name: column of the recording; its ending states the unit.
        source: column of the foreign file.
        factor: from the source's unit to that of `name`.
    """

    name: str
    source: str
    factor: float = 1.0


def parse_mapping(text: str) -> ColumnMapping:
    """Read one `--map` argument.

    Raises:
        RecordingError: not of one of the three forms, an unknown unit (with the list of known ones), or a
            source whose
            name states another unit than ours without a factor.
    """
    match = _FORM.match(text)
    if match is None:
        raise RecordingError(f"mapping {text!r} must read NEW=OLD, NEW=OLD*FACTOR or NEW=OLD[UNIT]")
    name, source = match["name"], match["source"]
    unit = unit_of(name)
    if unit is None:
        raise RecordingError(f"mapping {text!r}: {name!r} must end in one of {known_suffixes()}")
    if match["unit"] is not None:
        return ColumnMapping(name=name, source=source, factor=_conversion(match["unit"].strip(), unit, text))
    if match["factor"] is not None:
        return ColumnMapping(name=name, source=source, factor=_number(match["factor"], text))
    stated = stated_unit(source)
    if stated is not None and stated != unit:
        convertible = CONVERSIONS[stated][0] == unit
        remedy = f"{name}={source}[{stated}]" if convertible else f"{name}={source}*FACTOR"
        raise RecordingError(
            f"mapping {text!r}: {source!r} seems to be in {stated}, {name!r} is in {unit}; "
            f"say {remedy}, or {name}={source}*1 if it is in {unit} already"
        )
    return ColumnMapping(name=name, source=source)


def parse_mappings(texts: Iterable[str]) -> tuple[ColumnMapping, ...]:
    """Read all `--map` arguments.

    Raises:
        RecordingError: one of them is wrong, or two make the same column.
    """
    mappings = tuple(parse_mapping(text) for text in texts)
    names = [mapping.name for mapping in mappings]
    doubled = sorted({name for name in names if names.count(name) > 1})
    if doubled:
        raise RecordingError(f"mapped more than once: {', '.join(doubled)}")
    return mappings


def _conversion(source_unit: str, unit: str, text: str) -> float:
    if source_unit not in CONVERSIONS:
        raise RecordingError(
            f"mapping {text!r}: unknown unit {source_unit!r}; known are {known_units()}. "
            "For another give a factor: *0.5"
        )
    target, factor = CONVERSIONS[source_unit]
    if target != unit:
        raise RecordingError(f"mapping {text!r}: {source_unit} cannot become {unit}, only {target}")
    return factor


def _number(factor: str, text: str) -> float:
    try:
        value = float(factor)
    except ValueError:
        value = 0.0
    if value == 0.0 or value - value != 0.0:  # the second: not finite
        raise RecordingError(f"mapping {text!r}: factor {factor!r} must be a finite number other than 0")
    return value
