"""The table of effects: the agreed ids are all there, and its numbers are consistent."""

import pytest

from mock_dsp.scenario.effects import EFFECTS, EffectParameter
from mock_dsp.scenario.schema import Effect

CATALOGUE = {
    "torque": """coulomb_friction asymmetric_coulomb_friction asymmetric_viscous_friction stribeck_friction
        quadratic_drag load_torque_offset load_dependent_friction gravity_unbalance torque_ripple backlash
        belt_compliance presliding_hysteresis viscous_friction_drift position_dependent_inertia end_stop
        torque_saturation torque_constant_drift""",
    "current": "transport_delay current_loop_lag current_saturation inverter_dead_time",
    "sensor": """current_sensor_offset current_sensor_gain potentiometer_nonlinearity speed_filter_lag
        rectified_speed_sensor""",
}
PARAMETERS = [(name, parameter) for name, spec in EFFECTS.items() for parameter in spec.parameters]


@pytest.mark.parametrize("port", CATALOGUE)
def test_each_port_has_exactly_the_agreed_effects(port: str) -> None:
    catalogued = {name for name, spec in EFFECTS.items() if spec.port == port and spec.catalogued}
    assert catalogued == set(CATALOGUE[port].split())


def test_three_effects_are_outside_the_catalogue() -> None:
    outside = {name for name, spec in EFFECTS.items() if not spec.catalogued}
    assert outside == {"eddy_current_brake", "rotor_heating", "sticky_spot"}


@pytest.mark.parametrize(
    ("effect_id", "parameter"), PARAMETERS, ids=lambda value: getattr(value, "name", value)
)
def test_default_and_draw_lie_in_the_range(effect_id: str, parameter: EffectParameter) -> None:
    low, high = parameter.draw
    assert parameter.minimum <= low <= high <= parameter.maximum
    assert parameter.minimum <= parameter.default <= parameter.maximum


def test_an_effect_without_numbers_takes_the_defaults() -> None:
    given = Effect(id="stribeck_friction", parameters={"static_nm": 0.3})
    assert given.complete_parameters == {"static_nm": 0.3, "coulomb_nm": 0.12, "speed_rad_s": 0.15}
