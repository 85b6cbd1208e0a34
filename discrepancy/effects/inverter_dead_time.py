"""Dead time of the inverter: small currents are lost around zero."""

import math

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [{"lost_current": f * r.current, "width": m} for f in (0.03, 0.15) for m in (1.0, 3.0)]


INVERTER_DEAD_TIME = Effect(
    id="inverter_dead_time",
    port=Port.CURRENT,
    driver="current_ref_A",
    equation="i = u - I max(-1, min(1, u / (I m))), m >= 1",
    parameters=(
        EffectParameter(
            name="lost_current",
            slot=s.DEAD_CURRENT,
            kind=Kind.INPUT,
            lower=1e-09,
            upper=math.inf,
            meaning="current lost",
            logarithmic=True,
        ),
        EffectParameter(
            name="width",
            slot=s.DEAD_WIDTH,
            kind=Kind.RATIO,
            lower=1.0,
            upper=10.0,
            meaning="where the loss is complete, in units of it",
            free=False,
        ),
    ),
    starts=_starts,
    signature="torque residual that jumps with the sign of the current, not of the speed",
    confused_with=("coulomb_friction", "current_saturation"),
    reference="N. Urasaki et al., IEEE Trans. Ind. Electron. 2007 (dead-time effect)",
    inverse=False,
)
