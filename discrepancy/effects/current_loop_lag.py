"""Finite bandwidth of the current loop: first order."""

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [{"time_constant": d} for d in (0.003, 0.02, 0.1)]


CURRENT_LOOP_LAG = Effect(
    id="current_loop_lag",
    port=Port.CURRENT,
    driver="current_ref_A",
    equation="T i' = u - i",
    parameters=(
        EffectParameter(
            name="time_constant",
            slot=s.CURRENT_LAG,
            kind=Kind.TIME,
            lower=1e-05,
            upper=5.0,
            meaning="time constant",
            logarithmic=True,
        ),
    ),
    starts=_starts,
    signature="residual proportional to the slope of the input, attenuated at high frequency",
    confused_with=("transport_delay", "speed_filter_lag", "belt_compliance"),
    reference="W. Leonhard, Control of Electrical Drives",
    inverse=False,
)
