"""The speed sensor loses the sign (a tacho without direction, a frequency counter)."""

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [{"share": 1.0}, {"share": 0.1}]


RECTIFIED_SPEED_SENSOR = Effect(
    id="rectified_speed_sensor",
    port=Port.SENSOR,
    driver="speed_rad_s",
    equation="w_measured = w + r (|w| - w)",
    parameters=(
        EffectParameter(
            name="share",
            slot=s.RECTIFIED,
            kind=Kind.RATIO,
            lower=0.0,
            upper=1.0,
            meaning="1: only the magnitude is left",
        ),
    ),
    starts=_starts,
    signature="residual only while the speed is negative, twice its value",
    confused_with=("asymmetric_viscous_friction",),
    reference="incremental counters without direction: G. Ellis, Control System Design Guide",
    inverse=False,
)
