"""The current sensor reads in the wrong scale."""

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [{"gain": 1.05}]


CURRENT_SENSOR_GAIN = Effect(
    id="current_sensor_gain",
    port=Port.SENSOR,
    driver="current_A",
    equation="i_measured = g i",
    parameters=(
        EffectParameter(
            name="gain",
            slot=s.SENSOR_GAIN,
            kind=Kind.RATIO,
            lower=0.05,
            upper=20.0,
            meaning="gain",
            logarithmic=True,
        ),
    ),
    starts=_starts,
    signature="with current and speed alone the same as another torque constant",
    confused_with=(),
    reference="LEM, Hall-effect current transducers, application notes",
    inverse=False,
)
