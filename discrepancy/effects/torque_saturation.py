"""Torque that stops growing with the current (magnetic saturation)."""

import math

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [{"limit": f * r.torque, "exponent": n} for f in (1.0, 2.5) for n in (2.0, 12.0)]


TORQUE_SATURATION = Effect(
    id="torque_saturation",
    port=Port.TORQUE,
    driver="current_A",
    equation="tau = Kt i / (1 + |Kt i / T|^n)^(1/n)",
    parameters=(
        EffectParameter(
            name="limit",
            slot=s.TORQUE_LIMIT,
            kind=Kind.TORQUE,
            lower=1e-12,
            upper=math.inf,
            meaning="torque it tends to",
            logarithmic=True,
        ),
        EffectParameter(
            name="exponent",
            slot=s.TORQUE_LIMIT_EXPONENT,
            kind=Kind.RATIO,
            lower=1.0,
            upper=40.0,
            meaning="sharpness, large is a hard limit",
            logarithmic=True,
        ),
    ),
    starts=_starts,
    signature="torque residual odd and curved in the current, only at large current",
    confused_with=("current_saturation", "quadratic_drag", "inverter_dead_time"),
    reference="P. C. Krause et al., Analysis of Electric Machinery",
    inverse=False,
)
