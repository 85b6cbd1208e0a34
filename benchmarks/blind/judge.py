"""What the answer to one blind case is worth."""

import math
from collections.abc import Mapping
from enum import Enum
from typing import Any

from benchmarks.blind.conditions import IDS

Json = Mapping[str, Any]  # what json.loads returns


class Worth(Enum):
    """Worth of an answer, see `classify`."""

    RIGHT = "right"
    MISS = "miss"
    UNKNOWN = "unknown"
    WRONG = "wrong"


SPEED_LAW = frozenset({("torque", "speed_rad_s")})
PLACE_LAW = frozenset({("torque", "position_rad")})
PLACES: Mapping[str, frozenset[tuple[str, str]]] = {
    "eddy_current_brake": SPEED_LAW,
    "eddy_brake": SPEED_LAW,
    "cubic_drag": SPEED_LAW,
    "sticky_spot": PLACE_LAW,
    "spring": PLACE_LAW,
    # Heat slowly changes what torque and field a current makes: seen on either port, over time or current.
    "rotor_heating": frozenset(
        (port, driver)
        for port in ("torque", "current")
        for driver in ("time_s", "current_A", "current_ref_A")
    ),
}
"""Effects from outside the catalogue: port and driver at which `unknown` finds them."""

SCALE = "current_sensor_gain"


def classify(hidden: list[str], verdict: Json) -> Worth:
    """Return what the answer to one case is worth.

    `right`: verdict `named` and every hidden effect is named or declared equivalent to one that is, with no name
    beyond them; nothing hidden: `none`; an effect from outside the catalogue hidden: `unknown` without a name. A gain
    of the current sensor is another torque constant to whoever sees current and motion only: a corrected torque
    constant accounts for it.
    `wrong`: a name stands that is neither hidden nor declared equivalent to a hidden effect, whatever the verdict.
    `unknown`: something is left, no wrong name stands. `miss`: the rest: `none`, some of several effects not named, or
    no answer at all.
    """
    steps = [step for step in verdict["steps"] if step["added"] is not None]
    corrected = {change["parameter"] for change in verdict.get("parameter_changes", [])}
    accounted = [name for name in hidden if not (name == SCALE and "torque_constant" in corrected)]
    named_scale = any(SCALE in entry for step in steps for entry in readings(step))
    open_names = set(_in_parts(hidden if named_scale else accounted, {step["added"] for step in steps}))
    asked = bool(open_names)
    for step in steps:
        # Each name that stands must account for something that was hidden; a class may account for two.
        covered = max((entry for entry in readings(step) if entry <= open_names), key=len, default=None)
        if covered is None:
            return Worth.WRONG
        open_names -= covered
    if verdict["verdict"] == "unknown":
        outside = any(name not in IDS for name in hidden)
        return Worth.RIGHT if outside and not steps else Worth.UNKNOWN
    named = verdict["verdict"] == ("named" if asked else "none")
    return Worth.RIGHT if named and not open_names else Worth.MISS


def readings(step: Json) -> list[frozenset[str]]:
    """Return what a step may stand for: the name that it added, or any of its declared equivalents."""
    entries = [step["added"], *step["equivalents"]]
    return [frozenset([entry] if isinstance(entry, str) else entry) for entry in entries]


def _in_parts(hidden: list[str], named: set[str]) -> list[str]:
    """Return the hidden effects; asymmetric dry friction as the level and the offset that it is, if these are named."""
    whole, offsets = "asymmetric_coulomb_friction", {"load_torque_offset", "current_sensor_offset"}
    if whole not in hidden or "coulomb_friction" not in named or not offsets & named:
        return hidden
    return [name for name in hidden if name != whole] + ["coulomb_friction", min(offsets & named)]


def finds_place(hidden: list[str], verdict: Json) -> bool:
    """Return whether the answer `unknown` gives the port and the driver of an effect from outside the catalogue."""
    unknown = verdict.get("unknown")
    if not unknown:
        return False
    return any((unknown["port"], unknown["driver"]) in PLACES.get(name, frozenset()) for name in hidden)


def wilson(hits: int, total: int) -> tuple[float, float]:
    """Return the 95 % Wilson interval of a share."""
    if total == 0:
        return 0.0, 1.0
    z, share = 1.96, hits / total
    centre = (share + z * z / (2 * total)) / (1 + z * z / total)
    half = z * math.sqrt(share * (1 - share) / total + z * z / (4 * total**2)) / (1 + z * z / total)
    return max(0.0, centre - half), min(1.0, centre + half)
