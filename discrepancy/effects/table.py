"""The literal table of the catalogue: one line an effect. Documentation, search and tests run over it."""

from discrepancy.effects.asymmetric_coulomb_friction import ASYMMETRIC_COULOMB_FRICTION
from discrepancy.effects.asymmetric_viscous_friction import ASYMMETRIC_VISCOUS_FRICTION
from discrepancy.effects.backlash import BACKLASH
from discrepancy.effects.belt_compliance import BELT_COMPLIANCE
from discrepancy.effects.coulomb_friction import COULOMB_FRICTION
from discrepancy.effects.current_loop_lag import CURRENT_LOOP_LAG
from discrepancy.effects.current_saturation import CURRENT_SATURATION
from discrepancy.effects.current_sensor_gain import CURRENT_SENSOR_GAIN
from discrepancy.effects.current_sensor_offset import CURRENT_SENSOR_OFFSET
from discrepancy.effects.end_stop import END_STOP
from discrepancy.effects.gravity_unbalance import GRAVITY_UNBALANCE
from discrepancy.effects.inverter_dead_time import INVERTER_DEAD_TIME
from discrepancy.effects.load_dependent_friction import LOAD_DEPENDENT_FRICTION
from discrepancy.effects.load_torque_offset import LOAD_TORQUE_OFFSET
from discrepancy.effects.position_dependent_inertia import POSITION_DEPENDENT_INERTIA
from discrepancy.effects.potentiometer_nonlinearity import POTENTIOMETER_NONLINEARITY
from discrepancy.effects.presliding_hysteresis import PRESLIDING_HYSTERESIS
from discrepancy.effects.quadratic_drag import QUADRATIC_DRAG
from discrepancy.effects.rectified_speed_sensor import RECTIFIED_SPEED_SENSOR
from discrepancy.effects.spec import Effect
from discrepancy.effects.speed_filter_lag import SPEED_FILTER_LAG
from discrepancy.effects.stribeck_friction import STRIBECK_FRICTION
from discrepancy.effects.torque_constant_drift import TORQUE_CONSTANT_DRIFT
from discrepancy.effects.torque_ripple import TORQUE_RIPPLE
from discrepancy.effects.torque_saturation import TORQUE_SATURATION
from discrepancy.effects.transport_delay import TRANSPORT_DELAY
from discrepancy.effects.viscous_friction_drift import VISCOUS_FRICTION_DRIFT

EFFECTS: dict[str, Effect] = {
    effect.id: effect
    for effect in (
        COULOMB_FRICTION,
        ASYMMETRIC_COULOMB_FRICTION,
        ASYMMETRIC_VISCOUS_FRICTION,
        STRIBECK_FRICTION,
        QUADRATIC_DRAG,
        LOAD_TORQUE_OFFSET,
        LOAD_DEPENDENT_FRICTION,
        GRAVITY_UNBALANCE,
        TORQUE_RIPPLE,
        BACKLASH,
        BELT_COMPLIANCE,
        PRESLIDING_HYSTERESIS,
        VISCOUS_FRICTION_DRIFT,
        POSITION_DEPENDENT_INERTIA,
        END_STOP,
        TORQUE_SATURATION,
        TORQUE_CONSTANT_DRIFT,
        TRANSPORT_DELAY,
        CURRENT_LOOP_LAG,
        CURRENT_SATURATION,
        INVERTER_DEAD_TIME,
        CURRENT_SENSOR_OFFSET,
        CURRENT_SENSOR_GAIN,
        POTENTIOMETER_NONLINEARITY,
        SPEED_FILTER_LAG,
        RECTIFIED_SPEED_SENSOR,
    )
}
