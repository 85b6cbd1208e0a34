"""The hot path of the search: a joint with friction, drag, an offset and input timing only."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.laws import has_dry_friction, interpolate, slide

FloatArray = NDArray[np.float64]


@njit(cache=True, error_model="numpy")
def is_plain(p: FloatArray) -> bool:
    """Whether only friction, drag, an offset and input timing are on: no inner states, no angle, no sensor errors."""
    return bool(
        p[s.GRAVITY_WAVE] == 0.0
        and p[s.RIPPLE_WAVE] == 0.0
        and p[s.STOP_STIFFNESS] == 0.0
        and p[s.INERTIA_WAVE] == 0.0
        and p[s.POT_WAVE] == 0.0
        and p[s.LOAD_SHARE] == 0.0
        and p[s.PRESLIDING_LEVEL] == 0.0
        and p[s.CURRENT_LAG] == 0.0
        and p[s.FILTER_LAG] == 0.0
        and p[s.RECTIFIED] == 0.0
        and p[s.VISCOUS_DRIFT] == 0.0
        and p[s.CONSTANT_DRIFT] == 0.0
        and p[s.TORQUE_LIMIT] >= s.NO_LIMIT
        and p[s.CURRENT_LIMIT] >= s.NO_LIMIT
        and p[s.DEAD_CURRENT] == 0.0
        and p[s.SPLINE_DRIVER] == 0.0
    )


@njit(cache=True, error_model="numpy")
def simulate_plain(
    p: FloatArray, t: FloatArray, u: FloatArray, windows: NDArray[np.int64], starts: FloatArray
) -> FloatArray:
    """Do what `simulate_record` does, for a plain joint, with its states in registers: the search's hot path."""
    n = t.size
    out = np.empty((3, n))
    inertia, slip, offset, drag = p[s.INERTIA], p[s.ASYM_VISCOUS], p[s.LOAD_OFFSET], p[s.QUADRATIC]
    gain, bias = 1.0, 0.0
    if p[s.INPUT_IS_MEASURED] > 0.0:
        gain, bias = 1.0 / p[s.SENSOR_GAIN], p[s.SENSOR_OFFSET]
    is_dry = has_dry_friction(p)
    hold, shift = p[s.INPUT_HOLD] > 0.5, p[s.INPUT_SHIFT] + p[s.DELAY]
    w, q, accel, step, h, cuts, j, window = 0.0, 0.0, 0.0, -1.0, 0.0, 1, 0, 0
    for k in range(n):
        if window < windows.shape[0]:
            first = windows[window]
            if (first if first >= 0 else -first - 1) == k:
                w, q, accel = starts[window, 0], starts[window, 1], 0.0
                window += 1
        at_sample = u[k]
        if shift != 0.0:
            at_sample, j = interpolate(t, u, t[k] - shift, j, hold)
        out[0, k], out[1, k], out[2, k] = w, q, (at_sample - bias) * gain
        if k == n - 1:
            break
        dt = t[k + 1] - t[k]
        if dt != step:
            step, cuts = dt, max(1, int(math.ceil(dt / p[s.MAX_STEP] - 1e-6)))
            h = dt / cuts
        for c in range(cuts):
            if shift == 0.0 and not hold:
                command = u[k] + (u[k + 1] - u[k]) * (c + 0.5) / cuts
            else:
                command, j = interpolate(t, u, t[k] + (c + 0.5) * h - shift, j, hold)
            torque = p[s.TORQUE_CONSTANT] * (command - bias) * gain
            viscous = p[s.VISCOUS] + (slip if w > 0.0 else -slip)
            middle = w + 0.5 * h * accel
            drive = torque - offset - drag * abs(middle) * middle
            if is_dry:
                new = slide(p, w, h, drive, (inertia, viscous, torque, accel, 1.0))
            else:
                half = 0.5 * h * viscous
                new = (w * (inertia - half) + h * drive) / (inertia + half)
            q += 0.5 * h * (w + new)
            accel = (new - w) / h
            w = new
    if p[s.INPUT_IS_MEASURED] == 0.0:
        out[2] = out[2] * p[s.SENSOR_GAIN] + p[s.SENSOR_OFFSET]
    return out
