"""The measured speed passes a first-order filter, or the sensor does from which both speed and angle come."""

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [{"time_constant": d, "angle_too": form} for d in (0.003, 0.02, 0.1) for form in (0.0, 1.0)]


SPEED_FILTER_LAG = Effect(
    id="speed_filter_lag",
    port=Port.SENSOR,
    driver="frequency",
    equation="T w_m' = w - w_m",
    parameters=(
        EffectParameter(
            name="time_constant",
            slot=s.FILTER_LAG,
            kind=Kind.TIME,
            lower=1e-05,
            upper=5.0,
            meaning="time constant",
            logarithmic=True,
        ),
        EffectParameter(
            name="angle_too",
            slot=s.FILTERS_ANGLE,
            kind=Kind.RATIO,
            lower=0.0,
            upper=1.0,
            meaning="1: the measured angle passes the same filter (a filter at the sensor); 0: the speed alone",
            free=False,
        ),
    ),
    starts=_starts,
    signature="residual proportional to the acceleration",
    confused_with=("current_loop_lag", "transport_delay"),
    reference="G. Ellis, Control System Design Guide",
    inverse=False,
)
