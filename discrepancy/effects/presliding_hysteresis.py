"""Friction that first yields like a spring: microscopic displacement before sliding (Dahl)."""

import math

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start, stiffest
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    level = 0.2 * r.torque
    return [
        {"level": level, "stiffness": level / x, "exponent": n}
        for x in (0.003, 0.02, 0.1, 0.5)
        for n in (1.0, 2.0, 3.0)
    ]


def _limits(r: Ranges) -> dict[str, tuple[float, float]]:
    # Friction that the motor never overcame was never seen to slide: it could as well be a spring. No sine or random
    # step sequence has a peak of four times its rms.
    return {"level": (1e-9, 4.0 * r.torque), "stiffness": (1e-9, stiffest(r))}


PRESLIDING_HYSTERESIS = Effect(
    id="presliding_hysteresis",
    port=Port.TORQUE,
    driver="speed_rad_s",
    equation="tau = -sigma z, z' = w (1 - sigma z sign(w) / F)^n, n = 1 or 2; n = 3: eight springs in parallel that "
    "slip one by one",
    parameters=(
        EffectParameter(
            name="level",
            slot=s.PRESLIDING_LEVEL,
            kind=Kind.TORQUE,
            lower=1e-09,
            upper=math.inf,
            meaning="friction level in sliding",
            logarithmic=True,
        ),
        EffectParameter(
            name="stiffness",
            slot=s.PRESLIDING_STIFFNESS,
            kind=Kind.STIFFNESS,
            lower=1e-09,
            upper=math.inf,
            meaning="stiffness before sliding",
            logarithmic=True,
        ),
        EffectParameter(
            name="exponent",
            slot=s.PRESLIDING_SHAPE,
            kind=Kind.RATIO,
            lower=1.0,
            upper=3.0,
            meaning="1 or 2: how gradually it yields (Dahl); 3: springs that slip one by one (Maxwell slip)",
            free=False,
        ),
    ),
    starts=_starts,
    limits=_limits,
    signature="friction that follows the travelled angle after a reversal instead of jumping",
    confused_with=("coulomb_friction", "backlash", "stribeck_friction"),
    reference="P. R. Dahl, AIAA J. 14(12), 1976; C. Canudas de Wit et al., IEEE TAC 40(3), 1995; "
    "F. Al-Bender et al., IEEE TAC 50(11), 2005",
    contains=("coulomb_friction",),
)
