"""Effects that are the same by their equations: no measurement of this kind can tell them apart."""

from collections.abc import Sequence

from discrepancy.effects.table import EFFECTS

Equivalent = str | tuple[str, ...]
ASYMMETRIC, LEVEL_AND_DIP = "asymmetric_coulomb_friction", "stribeck_friction"


def exact_equivalents(added: Sequence[str]) -> list[Equivalent]:
    """Return what no measurement can tell from the newest effect, because the equations are the same."""
    newest = added[-1]
    if newest == ASYMMETRIC:
        return [("coulomb_friction", "load_torque_offset"), ("coulomb_friction", "current_sensor_offset")]
    pair = {"load_torque_offset": "current_sensor_offset", "current_sensor_offset": "load_torque_offset"}
    if newest in pair:
        same: list[Equivalent] = [pair[newest]]
        return [*same, ASYMMETRIC] if {"coulomb_friction", LEVEL_AND_DIP} & set(added) else same
    if newest == "coulomb_friction" and set(pair) & set(added):
        return [ASYMMETRIC]
    return []


def simpler_laws(name: str, added: Sequence[str]) -> tuple[str, ...]:
    """Return the laws that may say all that an effect of a model says: those that it contains, and what is left of it.

    Beside Stribeck friction, which has a level of its own, all that dry friction of two levels adds is an offset.
    """
    contained = EFFECTS[name].contains
    return (*contained, "load_torque_offset") if name == ASYMMETRIC and LEVEL_AND_DIP in added else contained
