"""Inertia that changes with the angle (an arm that swings a mass in and out)."""

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [
        {"sine": 0.05, "cosine": 0.05, "wave_number": k, "reaction": c}
        for k in (*r.waves.get("acceleration", ()), 1.0, 2.0, 0.25)
        for c in (1.0, 0.0)
    ]


def _limits(r: Ranges) -> dict[str, tuple[float, float]]:
    # A longer wave is a constant within the travel: the inertia's own size, against which all else is measured.
    return {"wave_number": (min(1.0, 0.7 / (r.high - r.low)), 100.0)}


POSITION_DEPENDENT_INERTIA = Effect(
    id="position_dependent_inertia",
    port=Port.TORQUE,
    driver="acceleration_rad_s2",
    equation="J(q) = J (1 + s sin(k q) + c cos(k q)), with its reaction torque J'(q) w^2 / 2",
    parameters=(
        EffectParameter(
            name="sine", slot=s.INERTIA_SIN, kind=Kind.RATIO, lower=-0.95, upper=0.95, meaning="sine part"
        ),
        EffectParameter(
            name="cosine", slot=s.INERTIA_COS, kind=Kind.RATIO, lower=-0.95, upper=0.95, meaning="cosine part"
        ),
        EffectParameter(
            name="wave_number",
            slot=s.INERTIA_WAVE,
            kind=Kind.WAVE,
            lower=0.01,
            upper=100.0,
            meaning="periods per turn",
            logarithmic=True,
        ),
        EffectParameter(
            name="reaction",
            slot=s.INERTIA_REACTION,
            kind=Kind.RATIO,
            lower=0.0,
            upper=1.0,
            meaning="1: with the reaction torque",
            free=False,
        ),
    ),
    starts=_starts,
    limits=_limits,
    signature="torque residual proportional to the acceleration, with a sign that depends on the angle",
    confused_with=("gravity_unbalance", "torque_ripple"),
    reference="J. J. Craig, Introduction to Robotics, ch. 6",
)
