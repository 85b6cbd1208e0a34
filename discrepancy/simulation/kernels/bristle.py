"""Presliding friction: the springs that bend before the joint slides."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from discrepancy.simulation import slots as s

FloatArray = NDArray[np.float64]

SLIPS = 8
SPRINGS = 1 + SLIPS
"""The bristle of Dahl's law, then the springs that slip one after the other; deflections, all zero at first."""


@njit(cache=True, error_model="numpy")
def slip_torque(springs: FloatArray, level: float, stiffness: float, travel: float) -> float:
    """Move equal springs that slip one after the other (Maxwell slip, Iwan) by `travel`; return their mean torque.

    Spring i of n holds the deflection d i / n at most, so that all of them together carry `level` when they slide.
    """
    widest = 2.0 * SLIPS / (SLIPS + 1.0) * level / stiffness
    total = 0.0
    for i in range(SLIPS):
        most = widest * (i + 1) / SLIPS
        old = springs[1 + i]
        new = min(most, max(-most, old + travel))
        springs[1 + i] = new
        total += old + new
    return 0.5 * stiffness / SLIPS * total


@njit(cache=True, error_model="numpy")
def load_springs(p: FloatArray, springs: FloatArray, torque: float) -> None:
    """Set the presliding springs as they stand at rest under an outer torque, N m, that has grown from zero.

    A weight or an offset has bent them before a record begins.
    """
    level, stiffness = p[s.PRESLIDING_LEVEL], p[s.PRESLIDING_STIFFNESS]
    side = 1.0 if torque > 0.0 else -1.0
    bent = min(abs(torque), level) / stiffness
    springs[0] = side * bent
    widest = 2.0 * SLIPS / (SLIPS + 1.0) * level / stiffness
    # All springs bend alike until the first ones slip: `left` is what the others still have to carry, over stiffness.
    left, travel = bent * SLIPS, 0.0
    for i in range(SLIPS):
        most = widest * (i + 1) / SLIPS
        travel = left / (SLIPS - i)
        if travel <= most:
            break
        left -= most
    for i in range(SLIPS):
        springs[1 + i] = side * min(travel, widest * (i + 1) / SLIPS)


@njit(cache=True, error_model="numpy")
def bristle_torque(p: FloatArray, springs: FloatArray, travel: float) -> float:
    """Move the presliding springs by `travel`, return their mean torque: Dahl of exponent 1 or 2, exact, or slips."""
    level, stiffness = p[s.PRESLIDING_LEVEL], p[s.PRESLIDING_STIFFNESS]
    if p[s.PRESLIDING_SHAPE] > 2.5:
        return slip_torque(springs, level, stiffness, travel)
    if travel == 0.0:
        return float(springs[0] * stiffness)
    end = level / stiffness * (1.0 if travel > 0.0 else -1.0)
    path = abs(travel) * stiffness / level
    old = springs[0]
    left = 1.0 - old / end
    if p[s.PRESLIDING_SHAPE] > 1.5:
        left = left / (1.0 + path * left)
    else:
        left *= math.exp(-path)
    springs[0] = end * (1.0 - left)
    return float(0.5 * stiffness * (old + springs[0]))
