"""The drive acts later than commanded (communication, sampling, PWM)."""

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [{"delay": d} for d in (0.005, 0.02, 0.06)]


TRANSPORT_DELAY = Effect(
    id="transport_delay",
    port=Port.CURRENT,
    driver="time_s",
    equation="i(t) = u(t - T)",
    parameters=(
        EffectParameter(name="delay", slot=s.DELAY, kind=Kind.TIME, lower=0.0, upper=2.0, meaning="delay"),
    ),
    starts=_starts,
    signature="residual proportional to the slope of the input, phase falls linearly with frequency",
    confused_with=("current_loop_lag", "speed_filter_lag", "belt_compliance"),
    reference="K. J. Astrom, R. M. Murray, Feedback Systems",
    inverse=False,
)
