"""A constant torque: a hanging load, a spring, or what an offset of the current sensor looks like."""

import math

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [{"torque": 0.05 * r.torque}]


LOAD_TORQUE_OFFSET = Effect(
    id="load_torque_offset",
    port=Port.TORQUE,
    driver="speed_rad_s",
    equation="tau = -T0",
    parameters=(
        EffectParameter(
            name="torque",
            slot=s.LOAD_OFFSET,
            kind=Kind.TORQUE,
            lower=-math.inf,
            upper=math.inf,
            meaning="constant load torque",
        ),
    ),
    starts=_starts,
    signature="constant torque residual",
    confused_with=("current_sensor_offset", "asymmetric_viscous_friction", "gravity_unbalance"),
    reference="A. Janot, M. Gautier, M. Brunot, EMPS benchmark, 2019",
)
