"""Where each number of the simulated joint stands in the kernel's parameter vector.

A slot at its neutral value switches its effect off. Angles are rad, torques N m (m and N on a linear axis), currents A.
The kernel imports these names, so that one effect's file, the kernel and the tests mean the same number.
"""

import numpy as np
from numpy.typing import NDArray

INERTIA, VISCOUS, TORQUE_CONSTANT, INPUT_SHIFT, INPUT_HOLD, MAX_STEP, ANGLE_TIME = range(7)
COULOMB, ASYM_POSITIVE, ASYM_NEGATIVE, ASYM_VISCOUS = range(7, 11)
STRIBECK_COULOMB, STRIBECK_EXTRA, STRIBECK_SPEED, STRIBECK_EXPONENT = range(11, 15)
QUADRATIC, LOAD_OFFSET, LOAD_FRICTION = range(15, 18)
GRAVITY_SIN, GRAVITY_COS, GRAVITY_WAVE = range(18, 21)
RIPPLE_SIN, RIPPLE_COS, RIPPLE_WAVE, RIPPLE_CURRENT = range(21, 25)
LOAD_SHARE, STIFFNESS, DAMPING_RATIO, LOAD_FRICTION_SHARE, GAP = range(25, 30)
PRESLIDING_LEVEL, PRESLIDING_STIFFNESS = range(30, 32)
VISCOUS_DRIFT, VISCOUS_DRIFT_TIME, CONSTANT_DRIFT, CONSTANT_DRIFT_TIME = range(32, 36)
INERTIA_SIN, INERTIA_COS, INERTIA_WAVE, INERTIA_REACTION = range(36, 40)
STOP_HIGH, STOP_LOW, STOP_STIFFNESS, STOP_DAMPING = range(40, 44)
TORQUE_LIMIT, TORQUE_LIMIT_EXPONENT = range(44, 46)
DELAY, CURRENT_LAG, CURRENT_LIMIT, DEAD_CURRENT, DEAD_WIDTH = range(46, 51)
SENSOR_OFFSET, SENSOR_GAIN = range(51, 53)
POT_SIN, POT_COS, POT_WAVE = range(53, 56)
FILTER_LAG, RECTIFIED, INPUT_IS_MEASURED = range(56, 59)
PRESLIDING_SHAPE, OUTPUT_SMOOTHING, SENSOR_ON_LOAD, SMOOTHING_ORDER = range(59, 63)
FILTERS_ANGLE, SPLINE_DRIVER, SPLINE_COUNT, SPLINE_X = range(63, 67)
SPLINE_KNOTS = 16
SPLINE_Y = SPLINE_X + SPLINE_KNOTS
N_SLOTS = SPLINE_Y + SPLINE_KNOTS
SPLINE_OVER_SPEED, SPLINE_OVER_ANGLE, SPLINE_OVER_CURRENT = 1.0, 2.0, 3.0

NO_LIMIT = 1e30
"""Stands for an end stop or a limit that is never reached."""

_NEUTRAL: dict[int, float] = {
    INERTIA: 1.0,
    TORQUE_CONSTANT: 1.0,
    MAX_STEP: 2e-3,
    ANGLE_TIME: 0.2,
    STRIBECK_SPEED: 1.0,
    STRIBECK_EXPONENT: 2.0,
    DAMPING_RATIO: 0.1,
    PRESLIDING_STIFFNESS: 1.0,
    PRESLIDING_SHAPE: 1.0,
    VISCOUS_DRIFT_TIME: 1.0,
    CONSTANT_DRIFT_TIME: 1.0,
    INERTIA_REACTION: 1.0,
    STOP_HIGH: NO_LIMIT,
    STOP_LOW: -NO_LIMIT,
    TORQUE_LIMIT: NO_LIMIT,
    TORQUE_LIMIT_EXPONENT: 2.0,
    CURRENT_LIMIT: NO_LIMIT,
    DEAD_WIDTH: 1.0,
    SENSOR_GAIN: 1.0,
    SMOOTHING_ORDER: 2.0,
}


def neutral_vector() -> NDArray[np.float64]:
    """Return the vector of a joint without any effect, unit inertia and unit torque constant."""
    vector = np.zeros(N_SLOTS)
    for slot, value in _NEUTRAL.items():
        vector[slot] = value
    return vector
