"""One effect alone: the torque with which it opposes a motion, by the laws that the search fits. No physics here."""

import numpy as np
from numpy.typing import NDArray

from discrepancy.effects.spec import Effect
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.inverse import torque_record

FloatArray = NDArray[np.float64]

_NO_INERTIA = 1e-12
"""kg m^2; a joint needs some."""


def alone(effect: Effect, fitted: FloatArray) -> FloatArray:
    """Return a parameter vector that holds one effect of `fitted` and nothing else, both of shape (N_SLOTS,)."""
    vector = s.neutral_vector()
    vector[s.INERTIA], vector[s.TORQUE_CONSTANT] = _NO_INERTIA, 0.0
    for parameter in effect.parameters:
        vector[parameter.slot] = fitted[parameter.slot]
    return vector


def opposing_torque(
    vector: FloatArray,
    angle: FloatArray | float = 0.0,
    speed: FloatArray | float = 0.0,
    acceleration: FloatArray | float = 0.0,
    time: FloatArray | None = None,
) -> FloatArray:
    """Return the torque, N m, that a motion needs, shape (n,): with which the joint opposes it.

    Args:
        vector: of `alone`, or of a joint, shape (N_SLOTS,).
        angle: rad, shape (n,) or a constant; one of the four at least is an array.
        speed: rad/s, likewise.
        acceleration: rad/s^2, likewise.
        time: s, shape (n,), rising; samples a second apart if left out.
    """
    given = [angle, speed, acceleration, *([] if time is None else [time])]
    columns = [np.array(one, dtype=np.float64) for one in np.broadcast_arrays(*given)]
    n = columns[0].size
    seconds = np.arange(n, dtype=np.float64) if time is None else columns[3]
    motion = (columns[0], columns[1], columns[2])
    return np.asarray(torque_record(vector, seconds, np.zeros(n), motion, 0.0))


def with_zero(x: FloatArray) -> FloatArray:
    """Return a rising grid with two points close around zero, where dry friction jumps, if it holds zero inside."""
    low, high = float(x.min()), float(x.max())
    near = 1e-6 * max(abs(low), abs(high))
    return np.unique(np.concatenate([x, [-near, near]])) if low < 0.0 < high else x
