"""Generate `docs/effects.md` from the literal table: `python -m discrepancy.effects.document > docs/effects.md`."""

import sys

import numpy as np
from numpy.typing import NDArray

from discrepancy.effects.spec import Effect, Ranges
from discrepancy.effects.table import EFFECTS
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.inverse import torque_record

FloatArray = NDArray[np.float64]

HEAD = """# The catalogue of effects

Generated from `discrepancy/effects/table.py` (`python -m discrepancy.effects.document`); do not edit. The joint
without any
effect is J dw/dt = Kt i - B w. A torque written with a minus sign opposes the motion. On a linear axis read m, N and
kg for
rad, N m and kg m^2.
"""


def describe(effect: Effect) -> str:
    """Return the section of one effect."""
    rows = "\n".join(
        f"| `{p.name}` | {p.kind.value[0]} | {p.lower:.4g} .. {p.upper:.4g} | "
        f"{p.meaning}{'' if p.free else ' (from the starting grid)'} |"
        for p in effect.parameters
    )
    drivers = " and ".join(one for one in (effect.driver, effect.second_driver) if one is not None)
    confused = ", ".join(f"`{name}`" for name in effect.confused_with) or "nothing in the catalogue"
    return f"""## {effect.id}

`{effect.equation}`

Port: {effect.port.value}. Acts through: {drivers}. Signature: {effect.signature}.
Easily confused with: {confused}. Judged by torque: {"yes" if effect.inverse else "no"}. Reference: {effect.reference}.

| parameter | unit | bounds | meaning |
|---|---|---|---|
{rows}
{law_plot(effect)}"""


def law_plot(effect: Effect) -> str:
    """Return the torque law over speed as a plot of characters, for effects that are a law of the speed."""
    if not effect.inverse or effect.driver != "speed_rad_s":
        return ""
    speed = np.linspace(-1.0, 1.0, 41)
    torque = law_over_speed(effect, speed)
    top = float(np.max(np.abs(torque))) or 1.0
    rows = []
    for level in np.linspace(1.0, -1.0, 9):
        marks = "".join("*" if abs(v / top - level) <= 0.125 else " " for v in torque)
        rows.append(f"{level:+5.2f} |{marks}".rstrip())
    return (
        "\nOpposing torque over the speed, both relative to their largest value:\n\n```\n"
        + "\n".join(rows)
        + "\n```\n"
    )


def law_over_speed(effect: Effect, speed: FloatArray) -> FloatArray:
    """Return the opposing torque of one effect at its first starting values, for unit signals."""
    ranges = Ranges(
        torque=1.0,
        speed=1.0,
        current=1.0,
        duration=40.0,
        step=1e-3,
        low=-1.0,
        high=1.0,
        inertia=1.0,
        rate=1.0,
    )
    vector = s.neutral_vector()
    vector[s.INERTIA], vector[s.TORQUE_CONSTANT] = 1e-12, 0.0
    start = effect.starts(ranges)[0]
    for parameter in effect.parameters:
        vector[parameter.slot] = start.get(parameter.name, vector[parameter.slot])
    zeros = np.zeros(speed.size)
    time = np.arange(speed.size, dtype=np.float64)
    return np.asarray(torque_record(vector, time, zeros, (zeros, speed, zeros), 0.0))


def main() -> None:
    """Write the document to standard output."""
    sys.stdout.write("\n".join([HEAD, *(describe(effect) for effect in EFFECTS.values())]))


if __name__ == "__main__":
    main()
