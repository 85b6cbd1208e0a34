"""Numbers for people: as many digits as they deserve, with their unit."""

import math

from daq.recording.units import unit_of
from discrepancy.model.schema import Quantity

_PRINTED = {"rad/s2": "rad/s²", "m/s2": "m/s²", "rad/s^2": "rad/s²", "m/s^2": "m/s²", "1": ""}
_TORQUES = {"torque": "N m", "force": "N"}
NO_LIMIT = 1e29


def output_unit(name: str) -> str:
    """Return the unit of an output column, empty if its name does not tell."""
    unit = _TORQUES.get(name) or unit_of(name) or ""
    return pretty_unit(unit)


def pretty_unit(unit: str) -> str:
    """Return a unit as it is printed: superscripts for powers, nothing for a pure number."""
    return _PRINTED.get(unit, unit.replace("^2", "²"))


def significant(value: float, digits: int = 3) -> str:
    """Return a number with so many significant digits and no exponent where that is readable."""
    if value == 0.0 or not math.isfinite(value):
        return "0" if value == 0.0 else "not finite"
    exponent = math.floor(math.log10(abs(value)))
    if -5 < exponent < 6:
        rounded = round(value, digits - 1 - exponent)
        return f"{rounded:.{max(0, digits - 1 - exponent)}f}"
    return f"{value:.{digits - 1}e}"


def trimmed(value: float) -> str:
    """Return a setting with three digits at most and no trailing zeros."""
    return f"{value:.3g}"


def with_error(value: float, std: float | None) -> str:
    """Return `value ± std`: the error with two digits at most, the value to the same place."""
    if std is None or std <= 0.0 or not math.isfinite(std):
        return significant(value, 4)
    exponent = math.floor(math.log10(std))
    place = 1 - exponent if std / 10.0**exponent < 3.0 else -exponent
    if place > 7 or place < -5:
        return f"{value:.4g} ± {std:.1g}"
    shown = max(0, place)
    return f"{round(value, place) + 0.0:.{shown}f} ± {round(std, place):.{shown}f}"


def quantity(q: Quantity) -> str:
    """Return a parameter with its standard error and its unit."""
    text = with_error(q.value, None if q.fixed else q.std)
    return f"{text} {pretty_unit(q.unit)}".rstrip()


def percent(share: float) -> str:
    """Return a share in percent, never rounded to a flattering 0 or 100."""
    value = 100.0 * share
    if 0.0 < value < 0.01:
        return "less than 0.01 %"
    if 99.95 <= value < 100.0:
        return "more than 99.9 %"
    return f"{value:.2f} %" if abs(value) < 10.0 else f"{value:.1f} %"
