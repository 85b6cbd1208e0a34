"""An elastic belt or shaft: motor and load are two masses with a spring between."""

import math

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start, stiffest
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [
        {
            "load_share": a,
            "stiffness": r.inertia * a * (1 - a) * (2 * 3.14159 * f) ** 2,
            "damping_ratio": 0.1,
            "friction_share": a,
            "read_on_load": side,
        }
        for a in (0.2, 0.6, 0.95, 0.987)
        for f in (2.0, 6.0, 15.0)
        for side in (0.0, 1.0)
    ]


def _limits(r: Ranges) -> dict[str, tuple[float, float]]:
    # The reduced inertia of the two masses is at most a quarter of their sum.
    return {"stiffness": (1e-9, 0.25 * stiffest(r))}


BELT_COMPLIANCE = Effect(
    id="belt_compliance",
    port=Port.TORQUE,
    driver="frequency",
    equation="J_m w_m' = Kt i - T, J_l w_l' = T; T = K twist + D twist'",
    parameters=(
        EffectParameter(
            name="load_share",
            slot=s.LOAD_SHARE,
            kind=Kind.RATIO,
            lower=0.01,
            upper=0.995,
            meaning="share of the inertia behind the belt",
        ),
        EffectParameter(
            name="stiffness",
            slot=s.STIFFNESS,
            kind=Kind.STIFFNESS,
            lower=1e-09,
            upper=math.inf,
            meaning="stiffness",
            logarithmic=True,
        ),
        EffectParameter(
            name="damping_ratio",
            slot=s.DAMPING_RATIO,
            kind=Kind.RATIO,
            lower=0.002,
            upper=2.0,
            meaning="damping ratio",
            logarithmic=True,
        ),
        EffectParameter(
            name="friction_share",
            slot=s.LOAD_FRICTION_SHARE,
            kind=Kind.RATIO,
            lower=0.0,
            upper=1.0,
            meaning="share of all friction behind the belt; weight, stops and load act there wholly",
        ),
        EffectParameter(
            name="read_on_load",
            slot=s.SENSOR_ON_LOAD,
            kind=Kind.RATIO,
            lower=0.0,
            upper=1.0,
            meaning="1: speed and angle are measured behind the belt",
            free=False,
        ),
    ),
    starts=_starts,
    limits=_limits,
    signature="residual in a narrow band of frequency: resonance and anti-resonance",
    confused_with=("backlash", "current_loop_lag", "transport_delay"),
    reference="G. Ellis, R. Lorenz, IAS 2000 (resonant load control)",
    inverse=False,
)
