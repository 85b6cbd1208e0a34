"""Compiled recursion of the joint's nameplate model, for `daq.excitation.check`."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@njit(cache=True)
def simulate_joint(
    reference: Floats, transition: Floats, drive: Floats, start: Floats, gain: float
) -> tuple[Floats, Floats, Floats]:
    """Run x[k+1] = transition x[k] + drive reference[k] for x = (position, speed, slow position).

    Args:
        reference: Current held over each step, A, shape (n,).
        transition: Exact transition matrix of one step, shape (3, 3).
        drive: Response of the state to 1 A held over one step, shape (3,).
        start: State before the first step, shape (3,).
        gain: Centring gain, A/rad.

    Returns:
        Centring current (A), speed (rad/s) and position (rad) after each step, each of shape (n,).
    """
    n = reference.size
    centring, speed, position = np.empty(n), np.empty(n), np.empty(n)
    theta, omega, slow = start[0], start[1], start[2]
    for k in range(n):
        u = reference[k]
        theta, omega, slow = (
            transition[0, 0] * theta + transition[0, 1] * omega + transition[0, 2] * slow + drive[0] * u,
            transition[1, 0] * theta + transition[1, 1] * omega + transition[1, 2] * slow + drive[1] * u,
            transition[2, 0] * theta + transition[2, 1] * omega + transition[2, 2] * slow + drive[2] * u,
        )
        centring[k], speed[k], position[k] = -gain * slow, omega, theta
    return centring, speed, position


@njit(cache=True)
def simulate_driven(current: Floats, deviation: Floats, transition: Floats, drive: Floats) -> Floats:
    """Run x[k+1] = transition x[k] + drive (current[k], deviation[k]) from rest, x = (position, speed, slow position).

    Args:
        current: A, held over each step, shape (n,).
        deviation: added to the position that the low-pass sees, rad, shape (n,).
        transition: transition matrix of one step, shape (3, 3).
        drive: response of the state to each input held over one step, shape (3, 2).

    Returns:
        Position and slow position after each step, rad, shape (2, n).
    """
    n = current.size
    out = np.empty((2, n))
    state, new = np.zeros(3), np.zeros(3)
    for k in range(n):
        for row in range(3):
            new[row] = drive[row, 0] * current[k] + drive[row, 1] * deviation[k]
            for column in range(3):
                new[row] += transition[row, column] * state[column]
        state[:] = new
        out[0, k], out[1, k] = state[0], state[2]
    return out


@njit(cache=True)
def average_heat(heat: Floats, share: float) -> Floats:
    """Return the first-order average of `heat`, shape (n,), which takes `share` of each new value."""
    average = np.empty(heat.size)
    level = 0.0
    for k in range(heat.size):
        level += share * (heat[k] - level)
        average[k] = level
    return average
