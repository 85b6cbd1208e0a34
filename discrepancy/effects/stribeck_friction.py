"""Dry friction that falls from a break-away level to its Coulomb level as the speed rises."""

import math

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [
        {
            "coulomb_level": 0.15 * r.torque,
            "static_excess": 0.1 * r.torque,
            "stribeck_speed": f * r.speed,
            "exponent": e,
        }
        for f in (0.02, 0.07, 0.25)
        for e in (2.0, 1.0)
    ]


STRIBECK_FRICTION = Effect(
    id="stribeck_friction",
    port=Port.TORQUE,
    driver="speed_rad_s",
    equation="tau = -(F + (Fs - F) exp(-(|w|/ws)^2)) sign(w)",
    parameters=(
        EffectParameter(
            name="coulomb_level",
            slot=s.STRIBECK_COULOMB,
            kind=Kind.TORQUE,
            lower=0.0,
            upper=math.inf,
            meaning="level at high speed",
        ),
        EffectParameter(
            name="static_excess",
            slot=s.STRIBECK_EXTRA,
            kind=Kind.TORQUE,
            lower=0.0,
            upper=math.inf,
            meaning="break-away level above it",
        ),
        EffectParameter(
            name="stribeck_speed",
            slot=s.STRIBECK_SPEED,
            kind=Kind.SPEED,
            lower=0.0,
            upper=math.inf,
            meaning="speed at which it has fallen",
            logarithmic=True,
        ),
        EffectParameter(
            name="exponent",
            slot=s.STRIBECK_EXPONENT,
            kind=Kind.RATIO,
            lower=0.5,
            upper=4.0,
            meaning="shape of the fall",
            free=False,
        ),
    ),
    starts=_starts,
    signature="step at zero speed with a peak at low speed, stick-slip",
    confused_with=("coulomb_friction", "presliding_hysteresis", "quadratic_drag"),
    reference="R. Stribeck, Z. VDI 46, 1902; B. Armstrong-Helouvry et al., Automatica 30(7), 1994",
    contains=("coulomb_friction",),
    shared={"coulomb_level": ("coulomb_friction", "asymmetric_coulomb_friction", "presliding_hysteresis")},
)
