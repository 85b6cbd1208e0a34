"""Weight of an unbalanced arm: sinusoid of the joint angle, of at most one period per motor turn."""

import math

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [
        {"sine": 0.05 * r.torque, "cosine": 0.05 * r.torque, "wave_number": k}
        for k in (*r.waves.get("torque_low", ()), 1.0, 0.5, 0.25)
    ]


def _limits(r: Ranges) -> dict[str, tuple[float, float]]:
    # Within 0.35 rad of its centre a sine differs by less than 2 % from a straight line, the form error of any reduced
    # model: it could as well be a spring.
    return {"wave_number": (min(1.0, 0.7 / (r.high - r.low)), 1.2)}


GRAVITY_UNBALANCE = Effect(
    id="gravity_unbalance",
    port=Port.TORQUE,
    driver="position_rad",
    equation="tau = -(s sin(k q) + c cos(k q)), k <= 1 per rad",
    parameters=(
        EffectParameter(
            name="sine",
            slot=s.GRAVITY_SIN,
            kind=Kind.TORQUE,
            lower=-math.inf,
            upper=math.inf,
            meaning="sine amplitude",
        ),
        EffectParameter(
            name="cosine",
            slot=s.GRAVITY_COS,
            kind=Kind.TORQUE,
            lower=-math.inf,
            upper=math.inf,
            meaning="cosine amplitude",
        ),
        EffectParameter(
            name="wave_number",
            slot=s.GRAVITY_WAVE,
            kind=Kind.WAVE,
            lower=0.01,
            upper=1.2,
            meaning="joint turns per motor turn",
            logarithmic=True,
        ),
    ),
    starts=_starts,
    limits=_limits,
    signature="torque residual periodic in the angle, one period per joint turn",
    confused_with=("torque_ripple", "potentiometer_nonlinearity", "load_torque_offset"),
    reference="J. J. Craig, Introduction to Robotics, ch. 6",
)
