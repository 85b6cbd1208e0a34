"""Free play between motor and load: inside the gap the motor turns alone."""

import math

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start, stiffest
from discrepancy.simulation import slots as s

_CONTACT_HZ = 20.0


def _starts(r: Ranges) -> list[Start]:
    """Stand on a grid that is only simulated: gaps in parts of the travel."""
    travel = max(r.high - r.low, 1e-9)
    return [
        {
            "gap": g * travel,
            "load_share": a,
            "stiffness": min(r.inertia * a * (1 - a) * (2 * math.pi * _CONTACT_HZ) ** 2, 0.25 * stiffest(r)),
            "damping_ratio": 0.5,
            "friction_share": a,
            "read_on_load": side,
        }
        for g in (0.005, 0.01, 0.02, 0.04, 0.08, 0.16)
        for a in (0.3, 0.6, 0.9, 0.97, 0.99)
        for side in (0.0, 1.0)
    ]


def _limits(r: Ranges) -> dict[str, tuple[float, float]]:
    # The reduced inertia of the two masses is at most a quarter of their sum.
    return {"stiffness": (1e-9, 0.25 * stiffest(r))}


BACKLASH = Effect(
    id="backlash",
    port=Port.TORQUE,
    driver="speed_rad_s",
    equation="J_m w_m' = Kt i - T, J_l w_l' = T; T = K (twist -+ gap/2) + D twist', 0 inside the gap, contacts "
    "only push",
    parameters=(
        EffectParameter(
            name="gap",
            slot=s.GAP,
            kind=Kind.ANGLE,
            lower=1e-05,
            upper=math.inf,
            meaning="free play, peak to peak",
            logarithmic=True,
        ),
        EffectParameter(
            name="load_share",
            slot=s.LOAD_SHARE,
            kind=Kind.RATIO,
            lower=0.02,
            upper=0.995,
            meaning="share of the inertia behind the gap",
        ),
        EffectParameter(
            name="stiffness",
            slot=s.STIFFNESS,
            kind=Kind.STIFFNESS,
            lower=1e-09,
            upper=math.inf,
            meaning="contact stiffness",
            logarithmic=True,
        ),
        EffectParameter(
            name="damping_ratio",
            slot=s.DAMPING_RATIO,
            kind=Kind.RATIO,
            lower=0.01,
            upper=2.0,
            meaning="damping of the contact",
            logarithmic=True,
        ),
        EffectParameter(
            name="friction_share",
            slot=s.LOAD_FRICTION_SHARE,
            kind=Kind.RATIO,
            lower=0.0,
            upper=1.0,
            meaning="share of all friction behind the gap; weight, stops and load act there wholly",
        ),
        EffectParameter(
            name="read_on_load",
            slot=s.SENSOR_ON_LOAD,
            kind=Kind.RATIO,
            lower=0.0,
            upper=1.0,
            meaning="1: speed and angle are measured behind the gap",
            free=False,
        ),
    ),
    starts=_starts,
    limits=_limits,
    signature="torque residual spikes after each reversal of the torque",
    confused_with=("belt_compliance", "presliding_hysteresis", "coulomb_friction"),
    reference="M. Nordin, P.-O. Gutman, Automatica 38(10), 2002",
    inverse=False,
    chaotic=True,
    contains=("belt_compliance",),
)
