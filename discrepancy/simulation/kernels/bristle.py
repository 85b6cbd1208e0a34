"""Presliding friction: the bristle that bends before the joint slides, and the places of all inner states."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from discrepancy.simulation import slots as s

FloatArray = NDArray[np.float64]

W, Q, ANGLE, CURRENT, LOAD_SPEED, TWIST, BRISTLE, FILTERED, ACCEL = range(9)
N_STATES = 9


@njit(cache=True, error_model="numpy")
def bristle_torque(p: FloatArray, x: FloatArray, h: float) -> float:
    """Advance the presliding bristle (Dahl, exponent 1 or 2, exact) over `h` and return its mean torque."""
    level, stiffness = p[s.PRESLIDING_LEVEL], p[s.PRESLIDING_STIFFNESS]
    w = x[W] + 0.5 * h * x[ACCEL]
    if w == 0.0:
        return float(x[BRISTLE] * stiffness)
    end = level / stiffness * (1.0 if w > 0.0 else -1.0)
    travel = abs(w) * h * stiffness / level
    old = x[BRISTLE]
    left = 1.0 - old / end
    if p[s.PRESLIDING_SHAPE] > 1.5:
        left = left / (1.0 + travel * left)
    else:
        left *= math.exp(-travel)
    x[BRISTLE] = end * (1.0 - left)
    return float(0.5 * stiffness * (old + x[BRISTLE]))
