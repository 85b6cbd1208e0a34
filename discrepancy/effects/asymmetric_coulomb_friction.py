"""Dry friction whose level depends on the direction of the motion."""

import math

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [
        {"level_positive": 0.1 * r.torque, "level_negative": 0.1 * r.torque},
        {"level_positive": 0.5 * r.torque, "level_negative": 0.5 * r.torque},
    ]


ASYMMETRIC_COULOMB_FRICTION = Effect(
    id="asymmetric_coulomb_friction",
    port=Port.TORQUE,
    driver="speed_rad_s",
    equation="tau = -F+ for w > 0, +F- for w < 0; at rest between the two",
    parameters=(
        EffectParameter(
            name="level_positive",
            slot=s.ASYM_POSITIVE,
            kind=Kind.TORQUE,
            lower=0.0,
            upper=math.inf,
            meaning="level for positive speed",
        ),
        EffectParameter(
            name="level_negative",
            slot=s.ASYM_NEGATIVE,
            kind=Kind.TORQUE,
            lower=0.0,
            upper=math.inf,
            meaning="level for negative speed",
        ),
    ),
    starts=_starts,
    signature="step of the torque residual at zero speed, not centred: exactly a Coulomb level plus a torque offset",
    confused_with=("coulomb_friction", "load_torque_offset", "gravity_unbalance"),
    reference="A. Janot, M. Gautier, M. Brunot, EMPS benchmark, 2019",
    contains=("coulomb_friction",),
)
