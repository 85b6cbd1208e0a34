"""Units of columns: a column's name ends in its unit, and that ending is looked up here.

The names that the rest of the program knows are in SI; the units in `CONVERSIONS` are accepted where data
come in and are converted there. Nothing here guesses: a name without a known ending has no unit.
"""

import math
from typing import Final

# Ending of a column's name -> unit. Longer endings are tried first ("_rad_s" before "_s").
SUFFIX_UNITS: Final[dict[str, str]] = {
    "rad_s2": "rad/s^2",
    "rad_s": "rad/s",
    "m_s2": "m/s^2",
    "m_s": "m/s",
    "Nm": "N m",
    "degC": "degC",
    "counts": "counts",
    "ratio": "1",
    "enable": "1",
    "flag": "1",
    "rad": "rad",
    "Hz": "Hz",
    "A": "A",
    "V": "V",
    "N": "N",
    "W": "W",
    "m": "m",
    "s": "s",
}

# Unit as others write it -> (unit in this program, factor).
CONVERSIONS: Final[dict[str, tuple[str, float]]] = {
    **{unit: (unit, 1.0) for unit in SUFFIX_UNITS.values()},
    "ns": ("s", 1e-9),
    "us": ("s", 1e-6),
    "ms": ("s", 1e-3),
    "min": ("s", 60.0),
    "mA": ("A", 1e-3),
    "mV": ("V", 1e-3),
    "kN": ("N", 1e3),
    "mN": ("N", 1e-3),
    "mNm": ("N m", 1e-3),
    "Nm": ("N m", 1.0),
    "mm": ("m", 1e-3),
    "mm/s": ("m/s", 1e-3),
    "deg": ("rad", math.pi / 180.0),
    "deg/s": ("rad/s", math.pi / 180.0),
    "turn": ("rad", 2.0 * math.pi),
    "turn/s": ("rad/s", 2.0 * math.pi),
    "rpm": ("rad/s", 2.0 * math.pi / 60.0),
    "percent": ("1", 1e-2),
}

_FOREIGN_SUFFIXES: Final[dict[str, str]] = {
    unit.replace("/", "_").replace(" ", ""): unit for unit in CONVERSIONS
}


def unit_of(column: str) -> str | None:
    """Return the unit that the ending of a column's name states, or None where there is none."""
    return next((unit for suffix, unit in SUFFIX_UNITS.items() if _ends_in(column, suffix)), None)


def stated_unit(column: str) -> str | None:
    """Return the unit that a foreign name's ending states ("speed_rpm" -> "rpm"), or None."""
    endings = sorted(_FOREIGN_SUFFIXES, key=len, reverse=True)
    foreign = next((_FOREIGN_SUFFIXES[ending] for ending in endings if _ends_in(column, ending)), None)
    return unit_of(column) or foreign


def known_suffixes() -> str:
    """List the endings of column names, for error messages."""
    return ", ".join(f"_{suffix} ({unit})" for suffix, unit in SUFFIX_UNITS.items())


def known_units() -> str:
    """List the units accepted from others, for error messages."""
    return ", ".join(sorted(CONVERSIONS, key=str.lower))


def _ends_in(column: str, suffix: str) -> bool:
    return column.endswith("_" + suffix)
