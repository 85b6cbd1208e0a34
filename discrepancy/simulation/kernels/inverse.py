"""Inverse dynamics: the torque that a measured motion needs, by the same laws."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.bristle import SPRINGS, bristle_torque
from discrepancy.simulation.kernels.frozen import freeze
from discrepancy.simulation.kernels.laws import (
    dry_level,
    inertia_at,
    position_torque,
    ripple_torque,
    viscous_coefficient,
)

FloatArray = NDArray[np.float64]


@njit(cache=True, error_model="numpy")
def torque_record(
    p: FloatArray,
    t: FloatArray,
    u: FloatArray,
    motion: tuple[FloatArray, FloatArray, FloatArray],
    nominal: float,
) -> FloatArray:
    """Return the motor torque that a measured motion needs, as the nominal torque constant would read it.

    Args:
        p: Parameter vector, shape (N_SLOTS,).
        t: Sample times, s, shape (n,).
        u: Input, shape (n,).
        motion: Measured angle, speed and acceleration, each of shape (n,).
        nominal: Torque constant that turns the input into the measured torque.

    Returns:
        Torque, shape (n,): equal to `nominal * u` where the model is right.
    """
    held = freeze(p)
    angle, speed, acceleration = motion
    out = np.empty(t.size)
    springs = np.zeros(SPRINGS)
    for k in range(t.size):
        q, w, time = angle[k], speed[k], t[k] - t[0]
        inertia, reaction = inertia_at(held, q)
        load = inertia * acceleration[k] + (reaction + held[s.QUADRATIC] * (1.0 if w > 0.0 else -1.0)) * w * w
        load += (
            viscous_coefficient(held, w, time) * w + held[s.LOAD_OFFSET] + position_torque(held, q, w, 0.0)
        )
        load += ripple_torque(held, q, 0.0)
        if held[s.PRESLIDING_LEVEL] > 0.0:
            step = t[k] - t[k - 1] if k > 0 else t[1] - t[0]
            load += bristle_torque(held, springs, (w + 0.5 * step * acceleration[k]) * step)
        if w != 0.0:
            sign = 1.0 if w > 0.0 else -1.0
            load += sign * dry_level(held, w, sign, 0.0)
            # T = load + mu |T| sign(w), solved for T: the measured current must not stand on this side.
            load /= 1.0 - held[s.LOAD_FRICTION] * (sign if load > 0.0 else -sign)
        out[k] = (
            load
            + (nominal - held[s.TORQUE_CONSTANT]) * u[k]
            + held[s.TORQUE_CONSTANT] * held[s.SENSOR_OFFSET]
        )
    return out
