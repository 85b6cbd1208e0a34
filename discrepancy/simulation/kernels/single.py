"""One mass with any effect but a compliant or loose shaft and presliding: most of what a search simulates.

The same equations as `joint`, with the few states that such a joint has in registers instead of an array.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.laws import (
    inertia_at,
    interpolate,
    limit_current,
    motor_torque,
    position_torque,
    slide,
    viscous_coefficient,
)

FloatArray = NDArray[np.float64]


@njit(cache=True, error_model="numpy")
def is_single(p: FloatArray) -> bool:
    """Whether the joint is one mass without presliding springs."""
    return bool(p[s.LOAD_SHARE] == 0.0 and p[s.PRESLIDING_LEVEL] == 0.0 and p[s.SENSOR_ON_LOAD] <= 0.5)


@njit(cache=True, error_model="numpy")
def has_dry_friction(p: FloatArray) -> bool:
    """Whether any dry friction is on."""
    dry = p[s.COULOMB] + p[s.ASYM_POSITIVE] + p[s.ASYM_NEGATIVE] + p[s.STRIBECK_COULOMB]
    return bool(dry + p[s.STRIBECK_EXTRA] + p[s.LOAD_FRICTION] > 0.0)


@njit(cache=True, error_model="numpy", inline="always")
def _next_speed(
    p: FloatArray, state: tuple[float, float, float], current: float, at: tuple[float, float], is_dry: bool
) -> float:
    """Return the speed after a sub-step; `state` holds speed, angle and acceleration, `at` sub-step and time, s."""
    w, angle, accel = state
    h, time = at
    q, middle = angle + 0.5 * h * w, w + 0.5 * h * accel
    torque = motor_torque(p, current, time)
    inertia, reaction = inertia_at(p, q)
    viscous = viscous_coefficient(p, w, time)
    drive = torque - p[s.LOAD_OFFSET] - position_torque(p, q, w, current)
    drive -= (reaction + p[s.QUADRATIC] * (1.0 if middle > 0.0 else -1.0)) * middle * middle
    if is_dry:
        return float(slide(p, w, h, drive, (inertia, viscous, torque, accel)))
    half = 0.5 * h * viscous
    return float((w * (inertia - half) + h * drive) / (inertia + half))


@njit(cache=True, error_model="numpy", inline="always")
def _seen_motion(p: FloatArray, w: float, q: float, filtered: float) -> tuple[float, float]:
    """Return speed and position as the sensors report them."""
    speed = filtered if p[s.FILTER_LAG] > 0.0 else w
    if p[s.POT_WAVE] != 0.0:
        a = p[s.POT_WAVE] * q
        sin, cos = math.sin(a), math.cos(a)
        speed *= 1.0 + p[s.POT_WAVE] * (p[s.POT_SIN] * cos - p[s.POT_COS] * sin)
        q += p[s.POT_SIN] * sin + p[s.POT_COS] * cos
    if p[s.RECTIFIED] > 0.0:
        speed += p[s.RECTIFIED] * (abs(speed) - speed)
    return speed, q


@njit(cache=True, error_model="numpy")
def simulate_single(
    p: FloatArray,
    t: FloatArray,
    u: FloatArray,
    angle: FloatArray,
    windows: NDArray[np.int64],
    starts: FloatArray,
) -> FloatArray:
    """Do what `simulate_record` does, for one mass without presliding."""
    n = t.size
    out = np.empty((3, n))
    hold, shift, lag = p[s.INPUT_HOLD] > 0.5, p[s.INPUT_SHIFT] + p[s.DELAY], p[s.CURRENT_LAG]
    is_dry, is_filtered = has_dry_friction(p), p[s.FILTER_LAG] > 0.0
    w, q, seen, accel, current, filtered = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    step, h, lag_left, filter_left, pull, cuts, j, window = -1.0, 0.0, 0.0, 0.0, 0.0, 1, 0, 0
    for k in range(n):
        if window < windows.shape[0]:
            first = windows[window]
            if (first if first >= 0 else -first - 1) == k:
                filtered = starts[window, 0] if first < 0 else filtered + starts[window, 0] - w
                w, q, accel = starts[window, 0], starts[window, 1], 0.0
                if first < 0:
                    at_start, j = interpolate(t, u, t[k] - shift, j, hold)
                    current, seen = limit_current(p, at_start), q
                window += 1
        if lag == 0.0:
            at_sample, j = interpolate(t, u, t[k] - shift, j, hold)
            current = limit_current(p, at_sample)
        out[0, k], out[1, k] = _seen_motion(p, w, q, filtered)
        out[2, k] = current
        if k == n - 1:
            break
        dt = t[k + 1] - t[k]
        if dt != step:
            step, cuts = dt, max(1, int(math.ceil(dt / p[s.MAX_STEP] - 1e-6)))
            h, pull = dt / cuts, min(1.0, dt / p[s.ANGLE_TIME])
            lag_left = math.exp(-h / lag) if lag > 0.0 else 0.0
            filter_left = math.exp(-dt / p[s.FILTER_LAG]) if is_filtered else 0.0
        before = w
        for c in range(cuts):
            middle = t[k] + (c + 0.5) * h
            command, j = interpolate(t, u, middle - shift, j, hold)
            target = limit_current(p, command)
            mean = target
            if lag > 0.0:
                mean = target + (current - target) * (1.0 - lag_left) * lag / h
                current = target + (current - target) * lag_left
            new = _next_speed(p, (w, seen, accel), mean, (h, middle - t[0]), is_dry)
            moved = 0.5 * h * (w + new)
            q, seen, accel, w = q + moved, seen + moved, (new - w) / h, new
        if is_filtered:
            ramp = (w - before) / dt * p[s.FILTER_LAG]
            filtered = w - ramp + (filtered - before + ramp) * filter_left
        if angle.size > 0:
            seen += (angle[k + 1] - seen) * pull
    if p[s.INPUT_IS_MEASURED] == 0.0:
        out[2] = out[2] * p[s.SENSOR_GAIN] + p[s.SENSOR_OFFSET]
    return out
