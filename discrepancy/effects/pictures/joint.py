"""The joint that the pictures show, with typical values of one effect, and its simulation. No physics of its own."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from discrepancy.effects.spec import Effect, Ranges
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.joint import simulate_record

FloatArray = NDArray[np.float64]

INERTIA, VISCOUS, TORQUE_CONSTANT = 0.02, 0.05, 0.5
"""kg m^2, N m s/rad, N m/A: a small robot joint."""
CURRENT, SPEED, TURN = 4.0, 10.0, float(np.pi)
"""Largest current, A, and speed, rad/s; the joint travels this far to both sides, rad."""
RANGES = Ranges(
    torque=1.0, speed=SPEED, current=CURRENT, duration=40.0, step=1e-3, low=-TURN, high=TURN,
    inertia=INERTIA, rate=VISCOUS / INERTIA,
)  # fmt: skip
_FINE = 2e-4
"""Longest sub-step of a simulation, s."""


def typical(effect: Effect, **changed: float) -> dict[str, float]:
    """Return the starting values in the middle of the grid from which the search fits; some may be changed."""
    starts = effect.starts(RANGES)
    return {**starts[len(starts) // 2], **changed}


def joint(effect: Effect | None = None, values: Mapping[str, float] | None = None) -> FloatArray:
    """Return the parameter vector, shape (N_SLOTS,), of the joint with one effect, or without any."""
    vector = s.neutral_vector()
    vector[s.INERTIA], vector[s.VISCOUS], vector[s.TORQUE_CONSTANT] = INERTIA, VISCOUS, TORQUE_CONSTANT
    vector[s.MAX_STEP] = _FINE
    for parameter in effect.parameters if effect is not None else ():
        vector[parameter.slot] = (values or {}).get(parameter.name, vector[parameter.slot])
    return vector


def simulate(
    vector: FloatArray, time: FloatArray, command: FloatArray, speed: float = 0.0, angle: float = 0.0
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return what the sensors read, speed, rad/s, angle, rad, and current, A, each of shape (n,).

    Args:
        vector: of `joint`, shape (N_SLOTS,).
        time: s, shape (n,), rising.
        command: current, A, shape (n,), held from one sample to the next.
        speed: at the start, rad/s.
        angle: at the start, rad.
    """
    held = vector.copy()
    held[s.INPUT_HOLD] = 1.0
    start = np.array([[speed, angle]])
    read = simulate_record(held, time, command, np.empty(0), np.array([-1]), start)
    return read[0], read[1], read[2]
