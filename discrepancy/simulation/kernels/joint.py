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
from discrepancy.simulation.kernels.bristle import SPRINGS, bristle_torque, load_springs
from discrepancy.simulation.kernels.frozen import freeze
from discrepancy.simulation.kernels.laws import (
    has_dry_friction,
    inertia_at,
    interpolate,
    limit_current,
    motor_torque,
    position_torque,
    ripple_torque,
    slide,
    viscous_coefficient,
)
from discrepancy.simulation.kernels.plain import is_plain, simulate_plain

FloatArray = NDArray[np.float64]


@njit(cache=True, error_model="numpy", inline="always")
def shaft_torque(p: FloatArray, state: tuple[float, float, float], h: float) -> float:
    """Return the mean torque in the shaft over a sub-step; `state` holds both speeds and the twist."""
    share, free = p[s.LOAD_SHARE], 0.5 * p[s.GAP]
    w, load, twist = state
    twist += 0.5 * h * (w - load)
    wound = twist - free if twist > free else (twist + free if twist < -free else 0.0)
    if wound == 0.0 and free > 0.0:
        return 0.0
    damping = 2.0 * p[s.DAMPING_RATIO] * math.sqrt(p[s.STIFFNESS] * p[s.INERTIA] * share * (1.0 - share))
    torque = p[s.STIFFNESS] * wound + damping * (w - load)
    # A tooth cannot pull: inside a gap the contact only pushes.
    return 0.0 if free > 0.0 and torque * wound < 0.0 else torque


@njit(cache=True, error_model="numpy", inline="always")
def _move(
    p: FloatArray, w: float, h: float, drive: float, body: tuple[float, float, float, float, float], dry: bool
) -> float:
    """Return a body's speed after a sub-step; `body` as `slide` takes it."""
    if dry:
        return float(slide(p, w, h, drive, body))
    half = 0.5 * h * body[1]
    return (w * (body[0] - half) + h * drive) / (body[0] + half)


@njit(cache=True, error_model="numpy", inline="always")
def _next_speeds(
    p: FloatArray,
    state: tuple[float, float, float, float, float, float],
    springs: FloatArray | None,
    current: float,
    at: tuple[float, float, bool],
) -> tuple[float, float]:
    """Return the speeds of motor and load after a sub-step, and advance the presliding springs.

    `state` holds speed, angle, acceleration, speed and acceleration of the load, and twist; `at` sub-step and time, s,
    and whether any dry friction is on. Weight, stops and what else depends on the joint's angle act behind the shaft,
    friction on both sides of it by its share, ripple at the motor. Friction that grows with the load follows what
    arrives at its body: the motor's torque with its ripple, or the shaft's.
    """
    w, angle, accel, load, load_accel, twist = state
    h, time, is_dry = at
    q = angle + 0.5 * h * w
    torque = motor_torque(p, current, time) - ripple_torque(p, q, current)
    inertia, reaction = inertia_at(p, q)
    has_load = p[s.LOAD_SHARE] > 0.0
    body = load if has_load else w
    middle = body + 0.5 * h * (load_accel if has_load else accel)
    drag = p[s.QUADRATIC] * (1.0 if middle > 0.0 else -1.0) * middle * middle
    drive = -p[s.LOAD_OFFSET] - position_torque(p, q, body, current) - reaction * middle * middle - drag
    if springs is not None:
        drive -= bristle_torque(p, springs, middle * h)
    viscous = viscous_coefficient(p, body, time)
    if not has_load:
        return _move(p, w, h, drive + torque, (inertia, viscous, torque, accel, 1.0), is_dry), load
    behind = p[s.LOAD_FRICTION_SHARE]
    shaft = shaft_torque(p, (w, load, twist), h)
    front = p[s.INERTIA] * (1.0 - p[s.LOAD_SHARE])
    rest = max(0.05 * p[s.INERTIA] * p[s.LOAD_SHARE], inertia - front)
    moved = _move(p, load, h, drive + shaft, (rest, viscous * behind, shaft, load_accel, behind), is_dry)
    viscous = viscous_coefficient(p, w, time) * (1.0 - behind)
    return _move(p, w, h, torque - shaft, (front, viscous, torque, accel, 1.0 - behind), is_dry), moved


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
    # The slope of a filtered angle is the filtered speed: the angle is late by that times the time constant.
    late_by = p[s.FILTER_LAG] if p[s.FILTERS_ANGLE] > 0.5 else 0.0
    w, q, seen, accel, current, filtered = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    load, load_accel, twist = 0.0, 0.0, 0.0
    step, h, lag_left, filter_left, pull, cuts, j, window = -1.0, 0.0, 0.0, 0.0, 0.0, 1, 0, 0
    for k in range(n):
        if window < windows.shape[0]:
            first = windows[window]
            if (first if first >= 0 else -first - 1) == k:
                filtered, load = filtered + starts[window, 0] - w, load + starts[window, 0] - w
                w, q, accel, load_accel = starts[window, 0], starts[window, 1], 0.0, 0.0
                if first < 0:
                    at_start, j = interpolate(t, u, t[k] - shift, j, hold)
                    current, seen, filtered, load = limit_current(p, at_start), q, w, w
                    if springs is not None:
                        beyond = starts[window, 3] if starts.shape[1] > 3 else 0.0
                        load_springs(p, springs, beyond - p[s.LOAD_OFFSET] - position_torque(p, q, 0.0, 0.0))
                    side = 1.0 if current > 0.0 else -1.0
                    twist = 0.5 * p[s.GAP] * (starts[window, 2] if starts.shape[1] > 2 else side)
                window += 1
        if lag == 0.0:
            at_sample, j = interpolate(t, u, t[k] - shift, j, hold)
            current = limit_current(p, at_sample)
        shown, late = filtered if is_filtered else w, late_by * filtered
        out[0, k], out[1, k] = _seen_motion(
            p, (shown, q - late), (filtered if is_filtered else load, q - twist - late)
        )
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
            state = (w, seen, accel, load, load_accel, twist)
            new, behind = _next_speeds(p, state, springs, mean, (h, middle - t[0], is_dry))
            twist += 0.5 * h * (w + new - load - behind)
            load, load_accel = behind, (behind - load) / h
            moved = 0.5 * h * (w + new)
            q, seen, accel, w = q + moved, seen + moved, (new - w) / h, new
        if is_filtered:
            ramp = (w - before) / dt * p[s.FILTER_LAG]
            filtered = w - ramp + (filtered - before + ramp) * filter_left
        if angle.size > 0:
            seen += (angle[k + 1] + late_by * filtered - seen) * pull
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
        starts: Speed and angle at these samples, shape (m, 2); the third column is the place in the gap, in half gaps,
            the fourth what the presliding springs carry beyond the equilibrium, N m.

    Returns:
        Speed, position and current at each sample, shape (3, n).
    """
    if is_plain(p):
        return simulate_plain(freeze(p), t, u, windows, starts)
    # Compiled twice: a joint without springs keeps all its states in registers.
    if p[s.PRESLIDING_LEVEL] > 0.0:
        return _simulate(freeze(p), t, u, angle, windows, starts, np.zeros(SPRINGS))
    return _simulate(freeze(p), t, u, angle, windows, starts, None)
