"""Presliding friction: the bristle that bends before the joint slides, and the places of all inner states."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from discrepancy.simulation import slots as s

FloatArray = NDArray[np.float64]

W, Q, ANGLE, CURRENT, LOAD_SPEED, TWIST, BRISTLE, FILTERED, ACCEL = range(9)
SLIPS = 8
FIRST_SLIP = 9
N_STATES = FIRST_SLIP + SLIPS


@njit(cache=True, error_model="numpy")
def slip_torque(x: FloatArray, level: float, stiffness: float, travel: float) -> float:
    """Move equal springs that slip one after the other (Maxwell slip, Iwan) by `travel`; return their mean torque.

    Spring i of n holds the deflection d i / n at most, so that all of them together carry `level` when they slide.
    """
    widest = 2.0 * SLIPS / (SLIPS + 1.0) * level / stiffness
    total = 0.0
    for i in range(SLIPS):
        most = widest * (i + 1) / SLIPS
        old = x[FIRST_SLIP + i]
        new = min(most, max(-most, old + travel))
        x[FIRST_SLIP + i] = new
        total += old + new
    return 0.5 * stiffness / SLIPS * total


@njit(cache=True, error_model="numpy")
def bristle_torque(p: FloatArray, x: FloatArray, h: float) -> float:
    """Advance the presliding bristle over `h`, return its mean torque: Dahl of exponent 1 or 2, exact, or slips."""
    level, stiffness = p[s.PRESLIDING_LEVEL], p[s.PRESLIDING_STIFFNESS]
    w = x[W] + 0.5 * h * x[ACCEL]
    if p[s.PRESLIDING_SHAPE] > 2.5:
        return slip_torque(x, level, stiffness, w * h)
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
