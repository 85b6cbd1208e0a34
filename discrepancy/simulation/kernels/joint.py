"""The joint as one compiled loop: every effect on top of any other, dry friction treated exactly.

Theory of operation. Between two samples the step is cut into equal sub-steps. In a sub-step the current follows its
chain (delay, dead zone, limit, lag) at the middle of the step; smooth torques are taken at a predicted mid-point and
the viscous part implicitly, which is second order and stable for any step. Dry friction is never smoothed: a sub-step
in which the speed changes its sign is split where it passes through zero, and there the joint either sticks (the
driving torque is inside the break-away levels) or leaves in the direction of that torque. A joint with compliance or
backlash is two masses; the twist is advanced leap-frog. The angle that position-dependent effects see is the
simulated one, pulled towards the measured one with a time constant of ANGLE_TIME, so that it neither carries the
sensor's noise nor loses its phase. All states but the presliding springs are in registers.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.bristle import SPRINGS, bristle_torque
from discrepancy.simulation.kernels.laws import (
    has_dry_friction,
    inertia_at,
    interpolate,
    limit_current,
    motor_torque,
    position_torque,
    slide,
    viscous_coefficient,
)
from discrepancy.simulation.kernels.plain import is_plain, simulate_plain

FloatArray = NDArray[np.float64]


@njit(cache=True, error_model="numpy", inline="always")
def _shaft_torque(
    p: FloatArray, state: tuple[float, float, float], h: float, inertia: float, viscous: float
) -> tuple[float, float]:
    """Return the mean torque in the shaft and the load's new speed; `state` holds both speeds and the twist."""
    share, free = p[s.LOAD_SHARE], 0.5 * p[s.GAP]
    w, load, twist = state
    twist += 0.5 * h * (w - load)
    wound = twist - free if twist > free else (twist + free if twist < -free else 0.0)
    torque = 0.0
    if wound != 0.0 or free == 0.0:
        damping = 2.0 * p[s.DAMPING_RATIO] * math.sqrt(p[s.STIFFNESS] * inertia * share * (1.0 - share))
        torque = p[s.STIFFNESS] * wound + damping * (w - load)
        # A tooth cannot pull: inside a gap the contact only pushes.
        if free > 0.0 and torque * wound < 0.0:
            torque = 0.0
    mass, half = inertia * share, 0.5 * h * viscous * p[s.LOAD_FRICTION_SHARE]
    return torque, (load * (mass - half) + h * torque) / (mass + half)


@njit(cache=True, error_model="numpy", inline="always")
def _next_speeds(
    p: FloatArray,
    state: tuple[float, float, float, float, float],
    springs: FloatArray | None,
    current: float,
    at: tuple[float, float, bool],
) -> tuple[float, float]:
    """Return the speeds of motor and load after a sub-step, and advance the presliding springs.

    `state` holds speed, angle, acceleration, speed of the load and twist; `at` sub-step and time, s, and whether any
    dry friction is on.
    """
    w, angle, accel, load, twist = state
    h, time, is_dry = at
    q, middle = angle + 0.5 * h * w, w + 0.5 * h * accel
    torque = motor_torque(p, current, time)
    inertia, reaction = inertia_at(p, q)
    viscous = viscous_coefficient(p, w, time)
    drive = torque - p[s.LOAD_OFFSET] - position_torque(p, q, w, current)
    drive -= (reaction + p[s.QUADRATIC] * (1.0 if middle > 0.0 else -1.0)) * middle * middle
    if springs is not None:
        drive -= bristle_torque(p, springs, middle * h)
    if p[s.LOAD_SHARE] > 0.0:
        shaft, load = _shaft_torque(p, (w, load, twist), h, inertia, viscous)
        drive -= shaft
        viscous *= 1.0 - p[s.LOAD_FRICTION_SHARE]
        inertia *= 1.0 - p[s.LOAD_SHARE]
    if is_dry:
        return float(slide(p, w, h, drive, (inertia, viscous, torque, accel))), load
    half = 0.5 * h * viscous
    return (w * (inertia - half) + h * drive) / (inertia + half), load


@njit(cache=True, error_model="numpy", inline="always")
def _seen_motion(p: FloatArray, motor: tuple[float, float], load: tuple[float, float]) -> tuple[float, float]:
    """Return speed and position as the sensors report them, which stand on motor or load."""
    speed, q = load if p[s.SENSOR_ON_LOAD] > 0.5 else motor
    if p[s.POT_WAVE] != 0.0:
        a = p[s.POT_WAVE] * q
        sin, cos = math.sin(a), math.cos(a)
        speed *= 1.0 + p[s.POT_WAVE] * (p[s.POT_SIN] * cos - p[s.POT_COS] * sin)
        q += p[s.POT_SIN] * sin + p[s.POT_COS] * cos
    if p[s.RECTIFIED] > 0.0:
        speed += p[s.RECTIFIED] * (abs(speed) - speed)
    return speed, q


@njit(cache=True, error_model="numpy")
def _simulate(
    p: FloatArray,
    t: FloatArray,
    u: FloatArray,
    angle: FloatArray,
    windows: NDArray[np.int64],
    starts: FloatArray,
    springs: FloatArray | None,
) -> FloatArray:
    """Do what `simulate_record` does; `springs` are those of presliding, none without it."""
    n = t.size
    out = np.empty((3, n))
    hold, shift, lag = p[s.INPUT_HOLD] > 0.5, p[s.INPUT_SHIFT] + p[s.DELAY], p[s.CURRENT_LAG]
    is_dry, is_filtered = has_dry_friction(p), p[s.FILTER_LAG] > 0.0
    w, q, seen, accel, current, filtered, load, twist = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    step, h, lag_left, filter_left, pull, cuts, j, window = -1.0, 0.0, 0.0, 0.0, 0.0, 1, 0, 0
    for k in range(n):
        if window < windows.shape[0]:
            first = windows[window]
            if (first if first >= 0 else -first - 1) == k:
                filtered, load = filtered + starts[window, 0] - w, load + starts[window, 0] - w
                w, q, accel = starts[window, 0], starts[window, 1], 0.0
                if first < 0:
                    at_start, j = interpolate(t, u, t[k] - shift, j, hold)
                    current, seen, filtered, load = limit_current(p, at_start), q, w, w
                    if springs is not None:
                        springs[:] = 0.0
                    side = 1.0 if current > 0.0 else -1.0
                    twist = 0.5 * p[s.GAP] * (starts[window, 2] if starts.shape[1] > 2 else side)
                window += 1
        if lag == 0.0:
            at_sample, j = interpolate(t, u, t[k] - shift, j, hold)
            current = limit_current(p, at_sample)
        shown = filtered if is_filtered else w
        out[0, k], out[1, k] = _seen_motion(p, (shown, q), (filtered if is_filtered else load, q - twist))
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
            state = (w, seen, accel, load, twist)
            new, behind = _next_speeds(p, state, springs, mean, (h, middle - t[0], is_dry))
            twist += 0.5 * h * (w + new - load - behind)
            load = behind
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


@njit(cache=True, error_model="numpy")
def simulate_record(
    p: FloatArray,
    t: FloatArray,
    u: FloatArray,
    angle: FloatArray,
    windows: NDArray[np.int64],
    starts: FloatArray,
) -> FloatArray:
    """Simulate one record.

    Args:
        p: Parameter vector of `slots`, shape (N_SLOTS,).
        t: Sample times, s, shape (n,), rising; need not be uniform.
        u: Input (current, A, or force, N) at these times, shape (n,).
        angle: Measured angle, rad or m, shape (n,), or shape (0,) for the simulated one.
        windows: First sample of each window, shape (m,); `-k - 1` marks a window at k that begins afresh.
        starts: Speed and angle at these samples, shape (m, 2).

    Returns:
        Speed, position and current at each sample, shape (3, n).
    """
    if is_plain(p):
        return simulate_plain(p, t, u, windows, starts)
    # Compiled twice: a joint without springs keeps all its states in registers.
    if p[s.PRESLIDING_LEVEL] > 0.0:
        return _simulate(p, t, u, angle, windows, starts, np.zeros(SPRINGS))
    return _simulate(p, t, u, angle, windows, starts, None)
