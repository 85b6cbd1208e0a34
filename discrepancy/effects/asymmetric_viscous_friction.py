"""Viscous friction whose coefficient depends on the direction of the motion."""

import math

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [{"half_difference": 0.02 * r.torque / r.speed}]


ASYMMETRIC_VISCOUS_FRICTION = Effect(
    id="asymmetric_viscous_friction",
    port=Port.TORQUE,
    driver="speed_rad_s",
    equation="tau = -d |w|: B + d for w > 0, B - d for w < 0",
    parameters=(
        EffectParameter(
            name="half_difference",
            slot=s.ASYM_VISCOUS,
            kind=Kind.VISCOUS,
            lower=-math.inf,
            upper=math.inf,
            meaning="half the difference of the two coefficients",
        ),
    ),
    starts=_starts,
    signature="torque residual proportional to |speed|",
    confused_with=("load_torque_offset", "rectified_speed_sensor", "quadratic_drag"),
    reference="A. Janot, M. Gautier, M. Brunot, EMPS benchmark, 2019",
)
