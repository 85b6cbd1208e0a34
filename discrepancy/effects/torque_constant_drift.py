"""Torque constant that changes while the motor warms up."""

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [{"change": c, "time_constant": f * r.duration} for f in (0.1, 0.4, 2.0) for c in (-0.1,)]


TORQUE_CONSTANT_DRIFT = Effect(
    id="torque_constant_drift",
    port=Port.TORQUE,
    driver="time_s",
    equation="Kt(t) = Kt (1 + a (1 - exp(-t/T)))",
    parameters=(
        EffectParameter(
            name="change",
            slot=s.CONSTANT_DRIFT,
            kind=Kind.RATIO,
            lower=-0.98,
            upper=20.0,
            meaning="relative change at the end",
        ),
        EffectParameter(
            name="time_constant",
            slot=s.CONSTANT_DRIFT_TIME,
            kind=Kind.TIME,
            lower=0.05,
            upper=100000.0,
            meaning="time constant",
            logarithmic=True,
        ),
    ),
    starts=_starts,
    signature="residual proportional to the motor torque with a factor that changes over the record",
    confused_with=("viscous_friction_drift",),
    reference="rotor resistance and magnets against temperature: W. Leonhard, Control of Electrical Drives",
    inverse=False,
)
