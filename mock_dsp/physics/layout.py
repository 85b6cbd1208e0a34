"""Layout of the two records that the physics kernels share: the constants of the rig and its state.

Structured scalars rather than one array for each number, so that a kernel reads `plant["rotor_resistance"]`
and nobody counts indices. Effect parameters stand under `<effect id>.<parameter>`; 0 means absent.
"""

import numpy as np

from mock_dsp.scenario.effects import EFFECTS

HYSTERESIS_ELEMENTS = 4
DELAY_SLOTS = 512
NOISE_COLUMNS = 3

EFFECT_FIELDS = tuple(
    f"{effect_id}.{parameter.name}" for effect_id, spec in EFFECTS.items() for parameter in spec.parameters
)

_PLANT_FLOATS = (
    # Machine, SI; `determinant` is Ls Lr - Lm^2.
    "stator_resistance", "rotor_resistance", "stator_inductance", "rotor_inductance", "mutual_inductance",
    "determinant", "pole_pairs", "rated_current_squared",
    # Mechanics at the motor shaft: motor body (rotor, pulley) and load body (joint through the belt).
    "motor_inertia", "motor_viscous", "load_inertia", "load_viscous", "belt_ratio", "travel_stop",
    # Shaft between the bodies when it is not rigid.
    "shaft_stiffness", "shaft_damping", "shaft_half_gap",
    # Inverter and sensors.
    "bus_voltage", "dead_time", "current_noise", "potentiometer_noise_counts", "potentiometer_step_counts",
    "hall_gain", "monitor_gain", "wiper_gain", "reference_lag_gain",
)  # fmt: skip
_PLANT_INTEGERS = (
    "substeps", "joint_mode", "delay_ticks", "rectified_speed",
    # Fault windows in ticks, end excluded.
    "stuck_from", "stuck_to", "hall_from", "hall_to", "surge_from", "surge_to",
)  # fmt: skip
_FAULT_FLOATS = ("hall_shift_a", "surge_a")

PLANT_DTYPE = np.dtype(
    [(name, np.float64) for name in (*_PLANT_FLOATS, *_FAULT_FLOATS, *EFFECT_FIELDS)]
    + [(name, np.int64) for name in _PLANT_INTEGERS]
)

_STATE_FLOATS = (
    # Flux linkages in stator coordinates, V s.
    "stator_alpha", "stator_beta", "rotor_alpha", "rotor_beta",
    # Mechanics, at the motor shaft.
    "motor_speed", "motor_angle", "load_speed", "load_angle",
    # Slow quantities, renewed once a tick.
    "heat", "rotor_resistance_now", "load_viscous_now", "torque_factor",
    # Inverter: duties of the running period.
    "duty_a", "duty_b", "duty_c",
    # Sensors.
    "wiper", "lagged_reference",
    # Controller's program: see mock_dsp.control.
    "observed_angle", "observed_speed", "flux_estimate", "slip_angle", "integral_d", "integral_q",
    "centring_position", "i2t_heat",
)  # fmt: skip

STATE_DTYPE = np.dtype(
    [("tick", np.int64), ("position_counts", np.int64), ("repeats", np.int64), ("warm_ticks", np.int64)]
    + [("phase_a_counts", np.int64), ("phase_b_counts", np.int64)]
    + [(name, np.float64) for name in _STATE_FLOATS]
    + [("hysteresis", np.float64, (HYSTERESIS_ELEMENTS,)), ("delay_line", np.float64, (DELAY_SLOTS,))]
)

# Values of `joint_mode`.
JOINT_LINEAR = 0
JOINT_RIGID = 1
JOINT_TWO_BODIES = 2
