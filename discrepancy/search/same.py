"""Effects that are the same by their equations: no measurement of this kind can tell them apart."""

from collections.abc import Sequence

Equivalent = str | tuple[str, ...]


def exact_equivalents(added: Sequence[str]) -> list[Equivalent]:
    """Return what no measurement can tell from the newest effect, because the equations are the same."""
    newest = added[-1]
    if newest == "asymmetric_coulomb_friction":
        return [("coulomb_friction", "load_torque_offset"), ("coulomb_friction", "current_sensor_offset")]
    pair = {"load_torque_offset": "current_sensor_offset", "current_sensor_offset": "load_torque_offset"}
    if newest in pair:
        same: list[Equivalent] = [pair[newest]]
        return [*same, "asymmetric_coulomb_friction"] if "coulomb_friction" in added else same
    if newest == "coulomb_friction" and set(pair) & set(added):
        return ["asymmetric_coulomb_friction"]
    return []
