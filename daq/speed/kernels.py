"""Compiled loops of the Kalman speed filter; the equations are in `daq.speed.kalman`.

Time is counted in samples and the state is (position, speed * T, acceleration * T^2), so the transition is
the same for every sample time. Rows of `schedule` are (K0, K1, K2, 1/S, P10, P11, P12): gain, inverse
innovation variance and the filtered covariance's speed row, for the 1st, 2nd, ... sample after a start; the
last row is the steady state.
"""

import numpy as np
import numpy.typing as npt
from numba import njit

FloatArray = npt.NDArray[np.float64]


@njit(cache=True)
def filter_forward(
    schedule: FloatArray, position: FloatArray, state: FloatArray, speed: FloatArray, innovation: FloatArray
) -> None:
    """Run the filter over a block.

    Args:
        schedule: see the module.
        position: samples, shape (n,).
        state: position, speed, acceleration predicted for the next sample, and samples seen since the start,
            shape (4,);
            updated in place.
        speed: filtered speed * T, shape (n,), written.
        innovation: measured less predicted position, shape (n,), written.
    """
    last = schedule.shape[0] - 1
    seen = int(state[3])
    p, v, a = state[0], state[1], state[2]
    for k in range(position.shape[0]):
        row = seen + k if seen + k < last else last
        error = position[k] - p
        p += schedule[row, 0] * error
        v += schedule[row, 1] * error
        a += schedule[row, 2] * error
        speed[k] = v
        innovation[k] = error
        p += v + 0.5 * a
        v += a
    state[0], state[1], state[2] = p, v, a
    state[3] = seen + position.shape[0]


@njit(cache=True)
def smooth_backward(schedule: FloatArray, innovation: FloatArray, speed: FloatArray) -> None:
    """Turn filtered into smoothed speed, in place (modified Bryson-Frazier recursion).

    Args:
        schedule: see the module.
        innovation: of a forward run that began at its first sample, shape (n,).
        speed: filtered speed * T, shape (n,); smoothed on return.
    """
    last = schedule.shape[0] - 1
    l0, l1, l2 = 0.0, 0.0, 0.0  # lambda-hat: what the later samples say about this one's state
    for k in range(innovation.shape[0] - 1, -1, -1):
        row = k if k < last else last
        speed[k] -= schedule[row, 4] * l0 + schedule[row, 5] * l1 + schedule[row, 6] * l2
        along_gain = schedule[row, 0] * l0 + schedule[row, 1] * l1 + schedule[row, 2] * l2
        l0 -= along_gain + schedule[row, 3] * innovation[k]
        l2 += 0.5 * l0 + l1
        l1 += l0
