"""The literal table of the pictures: one line an effect, in the order of the catalogue."""

from collections.abc import Callable, Mapping

from discrepancy.effects.pictures import friction, motor, places, sensors, two_masses
from discrepancy.effects.pictures.spec import Picture
from discrepancy.effects.spec import Effect

PICTURES: Mapping[str, Callable[[Effect], Picture]] = {
    "coulomb_friction": friction.coulomb_friction,
    "asymmetric_coulomb_friction": friction.asymmetric_coulomb_friction,
    "asymmetric_viscous_friction": friction.asymmetric_viscous_friction,
    "stribeck_friction": friction.stribeck_friction,
    "quadratic_drag": friction.quadratic_drag,
    "load_torque_offset": friction.load_torque_offset,
    "load_dependent_friction": friction.load_dependent_friction,
    "gravity_unbalance": places.gravity_unbalance,
    "torque_ripple": places.torque_ripple,
    "backlash": two_masses.backlash,
    "belt_compliance": two_masses.belt_compliance,
    "presliding_hysteresis": friction.presliding_hysteresis,
    "viscous_friction_drift": friction.viscous_friction_drift,
    "position_dependent_inertia": places.position_dependent_inertia,
    "end_stop": places.end_stop,
    "torque_saturation": motor.torque_saturation,
    "torque_constant_drift": motor.torque_constant_drift,
    "transport_delay": motor.transport_delay,
    "current_loop_lag": motor.current_loop_lag,
    "current_saturation": motor.current_saturation,
    "inverter_dead_time": motor.inverter_dead_time,
    "current_sensor_offset": sensors.current_sensor_offset,
    "current_sensor_gain": sensors.current_sensor_gain,
    "potentiometer_nonlinearity": sensors.potentiometer_nonlinearity,
    "speed_filter_lag": sensors.speed_filter_lag,
    "rectified_speed_sensor": sensors.rectified_speed_sensor,
}
