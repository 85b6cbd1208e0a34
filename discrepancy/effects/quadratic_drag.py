"""Drag that grows with the square of the speed (fan, churning grease)."""

import math

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [{"coefficient": 0.1 * r.torque / r.speed**2}, {"coefficient": 0.5 * r.torque / r.speed**2}]


QUADRATIC_DRAG = Effect(
    id="quadratic_drag",
    port=Port.TORQUE,
    driver="speed_rad_s",
    equation="tau = -c |w| w",
    parameters=(
        EffectParameter(
            name="coefficient",
            slot=s.QUADRATIC,
            kind=Kind.QUADRATIC,
            lower=0.0,
            upper=math.inf,
            meaning="drag coefficient",
        ),
    ),
    starts=_starts,
    signature="torque residual odd and curved in speed",
    confused_with=("stribeck_friction", "torque_saturation", "coulomb_friction"),
    reference="A. Wahrburg et al., J. Dyn. Sys. 2018 (friction of robot joints)",
)
