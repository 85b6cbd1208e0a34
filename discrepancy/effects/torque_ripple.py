"""Cogging or winding harmonics: torque periodic in the motor angle, several periods per turn."""

import math

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    size = 0.05 * r.torque
    cogging: list[Start] = [
        {"sine": size, "cosine": size, "wave_number": k, "with_current": 0.0}
        for k in r.waves.get("torque_high", (2.0, 6.0))
    ]
    winding: list[Start] = [
        {"sine": 0.05, "cosine": 0.05, "wave_number": k, "with_current": 1.0}
        for k in r.waves.get("current", ())
    ]
    return cogging + winding


TORQUE_RIPPLE = Effect(
    id="torque_ripple",
    port=Port.TORQUE,
    driver="position_rad",
    equation="tau = -(s sin(k q) + c cos(k q)) [times i], k >= 1 per rad",
    parameters=(
        EffectParameter(
            name="sine",
            slot=s.RIPPLE_SIN,
            kind=Kind.TORQUE,
            lower=-math.inf,
            upper=math.inf,
            meaning="sine amplitude",
        ),
        EffectParameter(
            name="cosine",
            slot=s.RIPPLE_COS,
            kind=Kind.TORQUE,
            lower=-math.inf,
            upper=math.inf,
            meaning="cosine amplitude",
        ),
        EffectParameter(
            name="wave_number",
            slot=s.RIPPLE_WAVE,
            kind=Kind.WAVE,
            lower=0.8,
            upper=500.0,
            meaning="periods per turn",
            logarithmic=True,
        ),
        EffectParameter(
            name="with_current",
            slot=s.RIPPLE_CURRENT,
            kind=Kind.RATIO,
            lower=0.0,
            upper=1.0,
            meaning="1: proportional to the current",
            free=False,
        ),
    ),
    starts=_starts,
    signature="torque residual periodic in the angle, several periods per turn",
    confused_with=("gravity_unbalance", "potentiometer_nonlinearity"),
    reference="P. C. Krause et al., Analysis of Electric Machinery; cogging of a four-pole machine",
)
