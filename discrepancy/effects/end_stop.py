"""A mechanical stop inside the travel."""

import math

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start, stiffest
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    """Stand at the upper end, at the lower end, or at both; soft and hard."""
    travel = r.high - r.low
    far = {"high": r.high + travel, "low": r.low - travel, "damping": 0.1 * r.inertia * r.rate}
    stops = [{"high": r.high - f * travel} for f in (0.05, 0.2)]
    stops += [{"low": r.low + f * travel} for f in (0.05, 0.2)]
    stops += [{"high": r.high - 0.1 * travel, "low": r.low + 0.1 * travel}]
    return [{**far, **stop, "stiffness": k * r.torque / travel} for stop in stops for k in (20.0, 200.0)]


def _limits(r: Ranges) -> dict[str, tuple[float, float]]:
    """Keep each stop in its own outer part of the travel and stiff enough to be one.

    A spring that adds a tenth of the motor's torque over the whole travel, and no softer one: pressed against a bound
    that is too high, a soft stop would be fitted as a joint whose inertia is larger than the nameplate's.
    """
    travel = r.high - r.low
    return {
        "high": (r.high - 0.4 * travel, r.high + 10.0 * travel),
        "low": (r.low - 10.0 * travel, r.low + 0.4 * travel),
        "stiffness": (min(0.1 * r.torque / travel, 0.1 * stiffest(r)), stiffest(r)),
        "damping": (0.0, 20.0 * r.torque / r.speed),
    }


END_STOP = Effect(
    limits=_limits,
    id="end_stop",
    port=Port.TORQUE,
    driver="position_rad",
    equation="tau = -(K (q - q_stop) + D w) beyond the stop, never pulling",
    parameters=(
        EffectParameter(
            name="high", slot=s.STOP_HIGH, kind=Kind.ANGLE, lower=-1e30, upper=1e30, meaning="upper stop"
        ),
        EffectParameter(
            name="low", slot=s.STOP_LOW, kind=Kind.ANGLE, lower=-1e30, upper=1e30, meaning="lower stop"
        ),
        EffectParameter(
            name="stiffness",
            slot=s.STOP_STIFFNESS,
            kind=Kind.STIFFNESS,
            lower=1e-09,
            upper=math.inf,
            meaning="stiffness",
            logarithmic=True,
        ),
        EffectParameter(
            name="damping",
            slot=s.STOP_DAMPING,
            kind=Kind.VISCOUS,
            lower=0.0,
            upper=math.inf,
            meaning="damping",
        ),
    ),
    starts=_starts,
    signature="large torque residual beyond one angle only",
    confused_with=("gravity_unbalance", "position_dependent_inertia"),
    reference="B. Brogliato, Nonsmooth Mechanics, ch. 2",
)
