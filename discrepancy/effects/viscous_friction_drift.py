"""Viscous friction that changes while the grease warms up."""

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [{"change": c, "time_constant": f * r.duration} for f in (0.1, 0.4, 2.0) for c in (-0.2,)]


VISCOUS_FRICTION_DRIFT = Effect(
    id="viscous_friction_drift",
    port=Port.TORQUE,
    driver="time_s",
    equation="B(t) = B (1 + a (1 - exp(-t/T)))",
    parameters=(
        EffectParameter(
            name="change",
            slot=s.VISCOUS_DRIFT,
            kind=Kind.RATIO,
            lower=-0.98,
            upper=20.0,
            meaning="relative change at the end",
        ),
        EffectParameter(
            name="time_constant",
            slot=s.VISCOUS_DRIFT_TIME,
            kind=Kind.TIME,
            lower=0.05,
            upper=100000.0,
            meaning="time constant",
            logarithmic=True,
        ),
    ),
    starts=_starts,
    signature="residual proportional to speed with a factor that changes over the record",
    confused_with=("torque_constant_drift",),
    reference="P. Hamon et al., ICRA 2010; A. C. Bittencourt et al. (temperature in joint friction)",
)
