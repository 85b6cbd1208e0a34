"""Draw from a seed what a case hides: parameters, companions of an effect, and what the base model already holds."""

import math
from dataclasses import dataclass

import numpy as np

from benchmarks.blind.conditions import IDS, UNCOMBINED, Condition
from mock_dsp.scenario.effects import EFFECTS
from mock_dsp.scenario.schema import Effect

_FIXED = (
    "phase",
    "time_constant_s",
    "harmonic",
    "cycles",
    "speed",
    "critical",
    "centre",
    "width",
    "displacement",
)
_SCALED_TIMES = ("current_loop_lag", "speed_filter_lag")
_WHERE_IT_STANDS = ("lower_rad", "upper_rad")
_KINSHIP = (
    frozenset(
        {"coulomb_friction", "asymmetric_coulomb_friction", "stribeck_friction", "presliding_hysteresis"}
    ),
    frozenset({"load_torque_offset", "current_sensor_offset", "asymmetric_coulomb_friction"}),
    frozenset({"backlash", "belt_compliance"}),
    frozenset({"torque_saturation", "current_saturation"}),
    frozenset({"transport_delay", "current_loop_lag", "speed_filter_lag"}),
    frozenset({"torque_constant_drift", "viscous_friction_drift"}),
    frozenset({"gravity_unbalance", "end_stop"}),
)
"""Of each group at most one is hidden or held: together they would make one law, or one would hide the other."""

HOLDABLE = (
    "coulomb_friction",
    "stribeck_friction",
    "quadratic_drag",
    "load_torque_offset",
    "load_dependent_friction",
    "gravity_unbalance",
    "torque_ripple",
    "position_dependent_inertia",
    "asymmetric_viscous_friction",
)
"""Effects whose law in the emulator is that of the catalogue, so that true parameters exist."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawn:
    """What a case hides and what its base model holds."""

    hidden: tuple[Effect, ...]
    held: tuple[Effect, ...] = ()


def draw_parameters(name: str, generator: np.random.Generator, strength: float) -> dict[str, float]:
    """Draw an effect's parameters and make it weaker by `strength`, 0 < strength <= 1."""
    found = {}
    for parameter in EFFECTS[name].parameters:
        value = _weaken(name, parameter.name, float(generator.uniform(*parameter.draw)), strength)
        found[parameter.name] = float(np.clip(value, parameter.minimum, parameter.maximum))
    return found


def _weaken(name: str, parameter: str, value: float, strength: float) -> float:
    """Scale what makes an effect strong; shapes stay. A stiffer belt and a wider limit are weaker effects."""
    if name == "belt_compliance":
        # The damping ratio stays.
        return value / (strength if parameter.startswith("stiffness") else math.sqrt(strength))
    if parameter.startswith("limit"):
        return value / math.sqrt(strength)
    if name == "backlash" and not parameter.startswith("gap"):
        return value
    if parameter in _WHERE_IT_STANDS or (parameter.startswith(_FIXED) and name not in _SCALED_TIMES):
        return value
    neutral = 1.0 if "gain" in parameter else 0.0
    return neutral + (value - neutral) * strength


def related(first: str, second: str) -> bool:
    """Return whether two effects may not stand in one case."""
    if first == second or {first, second} & UNCOMBINED:
        return True
    return any({first, second} <= group for group in _KINSHIP)


def _companion(names: list[str], pool: tuple[str, ...], generator: np.random.Generator) -> str | None:
    fitting = [one for one in pool if not any(related(one, name) for name in names)]
    return str(generator.choice(fitting)) if fitting else None


def draw_case(condition: Condition, name: str, generator: np.random.Generator) -> Drawn:
    """Draw the effects of one case; `name` is the first of the hidden ones, if any is hidden."""
    names = [name] if condition.hidden else []
    while 0 < len(names) < condition.hidden:
        found = _companion(names, IDS, generator)
        if found is None:
            break
        names.append(found)
    held = _companion(names, HOLDABLE, generator) if condition.held else None
    return Drawn(
        hidden=tuple(
            Effect(id=one, parameters=draw_parameters(one, generator, condition.strength)) for one in names
        ),
        held=() if held is None else (Effect(id=held, parameters=draw_parameters(held, generator, 1.0)),),
    )
