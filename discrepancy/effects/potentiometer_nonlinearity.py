"""Linearity error of the potentiometer: periodic in its angle; a speed derived from it inherits the slope."""

import math

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [
        {"sine": 0.02 / k, "cosine": 0.02 / k, "wave_number": k}
        for k in (*r.waves.get("speed", ()), 0.1, 0.5, 1.0)
    ]


POTENTIOMETER_NONLINEARITY = Effect(
    id="potentiometer_nonlinearity",
    port=Port.SENSOR,
    driver="position_rad",
    equation="q_measured = q + s sin(k q) + c cos(k q); w_measured = dq_measured/dt",
    parameters=(
        EffectParameter(
            name="sine", slot=s.POT_SIN, kind=Kind.ANGLE, lower=-math.inf, upper=math.inf, meaning="sine part"
        ),
        EffectParameter(
            name="cosine",
            slot=s.POT_COS,
            kind=Kind.ANGLE,
            lower=-math.inf,
            upper=math.inf,
            meaning="cosine part",
        ),
        EffectParameter(
            name="wave_number",
            slot=s.POT_WAVE,
            kind=Kind.WAVE,
            lower=0.005,
            upper=12.0,
            meaning="periods per rad of travel",
            logarithmic=True,
        ),
    ),
    starts=_starts,
    signature="speed residual proportional to the speed, with a sign that depends on the angle",
    confused_with=("gravity_unbalance", "position_dependent_inertia"),
    reference="Vishay / Bourns, precision potentiometers: independent linearity",
    inverse=False,
)
