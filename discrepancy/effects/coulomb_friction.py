"""Dry friction of one level: it opposes the motion and holds the joint at rest."""

import math

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [{"level": 0.1 * r.torque}, {"level": 0.5 * r.torque}]


COULOMB_FRICTION = Effect(
    id="coulomb_friction",
    port=Port.TORQUE,
    driver="speed_rad_s",
    equation="tau = -F sign(w); at rest tau cancels the drive up to F",
    parameters=(
        EffectParameter(
            name="level",
            slot=s.COULOMB,
            kind=Kind.TORQUE,
            lower=0.0,
            upper=math.inf,
            meaning="friction level",
        ),
    ),
    starts=_starts,
    signature="step of the torque residual at zero speed, the joint stands still at small current",
    confused_with=(
        "asymmetric_coulomb_friction",
        "stribeck_friction",
        "presliding_hysteresis",
        "inverter_dead_time",
    ),
    reference="C. A. Coulomb, Theorie des machines simples, 1785; B. Armstrong-Helouvry et al., Automatica 30(7), 1994",
)
