"""The drive clips the current."""

import math

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [{"limit": f * r.current} for f in (0.9, 0.75, 0.5)]


CURRENT_SATURATION = Effect(
    id="current_saturation",
    port=Port.CURRENT,
    driver="current_ref_A",
    equation="i = max(-I, min(I, u))",
    parameters=(
        EffectParameter(
            name="limit",
            slot=s.CURRENT_LIMIT,
            kind=Kind.INPUT,
            lower=1e-12,
            upper=math.inf,
            meaning="current limit",
            logarithmic=True,
        ),
    ),
    starts=_starts,
    signature="no error below a current, all of it above",
    confused_with=("torque_saturation",),
    reference="W. Leonhard, Control of Electrical Drives",
    inverse=False,
)
