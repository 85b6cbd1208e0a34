"""The current sensor reads a constant too much."""

import math

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [{"offset": 0.02 * r.current}]


CURRENT_SENSOR_OFFSET = Effect(
    id="current_sensor_offset",
    port=Port.SENSOR,
    driver="current_A",
    equation="i_measured = i + I0",
    parameters=(
        EffectParameter(
            name="offset",
            slot=s.SENSOR_OFFSET,
            kind=Kind.INPUT,
            lower=-math.inf,
            upper=math.inf,
            meaning="offset",
        ),
    ),
    starts=_starts,
    signature="with current and speed alone the same as a torque offset",
    confused_with=("load_torque_offset", "gravity_unbalance"),
    reference="LEM, Hall-effect current transducers, application notes",
)
