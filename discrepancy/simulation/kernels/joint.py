"""The joint as one compiled loop: every effect on top of any other, dry friction treated exactly.

Theory of operation. Between two samples the step is cut into equal sub-steps. In a sub-step the current follows its
chain (delay, dead zone, limit, lag) at the middle of the step; smooth torques are taken at a predicted mid-point and
the
viscous part implicitly, which is second order and stable for any step. Dry friction is never smoothed: a sub-step in
which
the speed changes its sign is split where it passes through zero, and there the joint either sticks (the driving
torque is
inside the break-away levels) or leaves in the direction of that torque. A joint with compliance or backlash is two
masses;
the twist is advanced leap-frog. The angle that position-dependent effects see is the simulated one, pulled towards the
measured one with a time constant of ANGLE_TIME, so that it neither carries the sensor's noise nor loses its phase.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.bristle import (
    ACCEL,
    ANGLE,
    CURRENT,
    FILTERED,
    LOAD_SPEED,
    N_STATES,
    TWIST,
    Q,
    W,
    bristle_torque,
)
from discrepancy.simulation.kernels.laws import (
    inertia_at,
    interpolate,
    limit_current,
    motor_torque,
    position_torque,
    slide,
    viscous_coefficient,
)
from discrepancy.simulation.kernels.plain import is_plain, simulate_plain
from discrepancy.simulation.kernels.registers import simulate_rigid_friction

FloatArray = NDArray[np.float64]


@njit(cache=True, error_model="numpy")
def _shaft_torque(p: FloatArray, x: FloatArray, h: float, inertia: float, viscous: float) -> float:
    """Advance the load side by `h` and return the mean torque in the shaft between motor and load."""
    share = p[s.LOAD_SHARE]
    reduced = inertia * share * (1.0 - share)
    speed = x[W] - x[LOAD_SPEED]
    twist = x[TWIST] + 0.5 * h * speed
    free = 0.5 * p[s.GAP]
    wound = twist - free if twist > free else (twist + free if twist < -free else 0.0)
    torque = 0.0
    if wound != 0.0 or free == 0.0:
        damping = 2.0 * p[s.DAMPING_RATIO] * math.sqrt(p[s.STIFFNESS] * reduced)
        torque = p[s.STIFFNESS] * wound + damping * speed
        # A tooth cannot pull: inside a gap the contact only pushes.
        if free > 0.0 and torque * wound < 0.0:
            torque = 0.0
    load, drag = inertia * share, viscous * p[s.LOAD_FRICTION_SHARE]
    half = 0.5 * h * drag / load
    new = (x[LOAD_SPEED] * (1.0 - half) + h * torque / load) / (1.0 + half)
    x[LOAD_SPEED] = new
    return torque


@njit(cache=True, error_model="numpy")
def _advance(p: FloatArray, x: FloatArray, h: float, command: float, time: float) -> None:
    """Advance all states by one sub-step `h`, s, with the command current at its middle."""
    target = limit_current(p, command)
    current = target
    if p[s.CURRENT_LAG] > 0.0:
        decay = -math.expm1(-h / p[s.CURRENT_LAG])
        current = target + (x[CURRENT] - target) * decay * p[s.CURRENT_LAG] / h
        target += (x[CURRENT] - target) * (1.0 - decay)
    x[CURRENT] = target
    w, q = x[W], x[ANGLE] + 0.5 * h * x[W]
    torque = motor_torque(p, current, time)
    inertia, reaction = inertia_at(p, q)
    viscous = viscous_coefficient(p, w, time)
    middle = w + 0.5 * h * x[ACCEL]
    drive = torque - p[s.LOAD_OFFSET] - position_torque(p, q, w, current)
    drive -= (reaction + p[s.QUADRATIC] * (1.0 if middle > 0.0 else -1.0)) * middle * middle
    if p[s.PRESLIDING_LEVEL] > 0.0:
        drive -= bristle_torque(p, x, h)
    load = 0.0
    if p[s.LOAD_SHARE] > 0.0:
        load = x[LOAD_SPEED]
        drive -= _shaft_torque(p, x, h, inertia, viscous)
        viscous *= 1.0 - p[s.LOAD_FRICTION_SHARE]
        inertia *= 1.0 - p[s.LOAD_SHARE]
    new = slide(p, w, h, drive, (inertia, viscous, torque, x[ACCEL]))
    x[ACCEL] = (new - w) / h
    x[W] = new
    x[Q] += 0.5 * h * (w + new)
    x[ANGLE] += 0.5 * h * (w + new)
    if p[s.LOAD_SHARE] > 0.0:
        x[TWIST] += 0.5 * h * (w + new - load - x[LOAD_SPEED])


@njit(cache=True, error_model="numpy")
def _read_sensors(p: FloatArray, x: FloatArray, out: FloatArray, k: int) -> None:
    """Write speed, position and current of sample `k` as the sensors report them."""
    position, speed = x[Q], x[W]
    if p[s.SENSOR_ON_LOAD] > 0.5:
        position, speed = x[Q] - x[TWIST], x[LOAD_SPEED]
    if p[s.FILTER_LAG] > 0.0:
        speed = x[FILTERED]
    if p[s.POT_WAVE] != 0.0:
        a = p[s.POT_WAVE] * position
        sin, cos = math.sin(a), math.cos(a)
        speed *= 1.0 + p[s.POT_WAVE] * (p[s.POT_SIN] * cos - p[s.POT_COS] * sin)
        position += p[s.POT_SIN] * sin + p[s.POT_COS] * cos
    if p[s.RECTIFIED] > 0.0:
        speed += p[s.RECTIFIED] * (abs(speed) - speed)
    out[0, k] = speed
    out[1, k] = position
    out[2, k] = (
        x[CURRENT] * p[s.SENSOR_GAIN] + p[s.SENSOR_OFFSET] if p[s.INPUT_IS_MEASURED] == 0.0 else x[CURRENT]
    )


@njit(cache=True, error_model="numpy")
def _restart(p: FloatArray, x: FloatArray, start: FloatArray, current: float, fresh: bool) -> None:
    """Set speed and angle of a window's first sample; inner states stay unless the record begins here."""
    if fresh:
        x[:] = 0.0
        x[CURRENT] = limit_current(p, current)
        x[TWIST] = 0.5 * p[s.GAP] * (1.0 if current > 0.0 else -1.0)
        x[LOAD_SPEED] = start[0]
        x[FILTERED] = start[0]
    x[LOAD_SPEED] += start[0] - x[W] if not fresh else 0.0
    x[FILTERED] += start[0] - x[W] if not fresh else 0.0
    x[W], x[Q], x[ACCEL] = start[0], start[1], 0.0
    if fresh:
        x[ANGLE] = start[1]


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
    if p[s.PRESLIDING_LEVEL] == 0.0:
        return simulate_rigid_friction(p, t, u, angle, windows, starts)
    n = t.size
    out = np.empty((3, n))
    x = np.zeros(N_STATES)
    hold = p[s.INPUT_HOLD] > 0.5
    shift = p[s.INPUT_SHIFT] + p[s.DELAY]
    j, window, filter_step, filter_decay = 0, 0, -1.0, 0.0
    direct = shift == 0.0 and not hold
    for k in range(n):
        if window < windows.shape[0]:
            first = windows[window]
            if (first if first >= 0 else -first - 1) == k:
                at_start, j = interpolate(t, u, t[k] - shift, j, hold)
                _restart(p, x, starts[window], at_start, first < 0)
                window += 1
        if p[s.CURRENT_LAG] == 0.0:
            # The sub-steps leave the current of their middle behind; the sensor reads that of the sample.
            at_sample = u[k]
            if not direct:
                at_sample, j = interpolate(t, u, t[k] - shift, j, hold)
            x[CURRENT] = limit_current(p, at_sample)
        _read_sensors(p, x, out, k)
        if k == n - 1:
            break
        dt = t[k + 1] - t[k]
        w = x[W]
        if dt <= p[s.MAX_STEP] * 1.000001:
            cuts = 1
            h = dt
        else:
            cuts = int(math.ceil(dt / p[s.MAX_STEP] - 1e-6))
            h = dt / cuts
        if direct and cuts == 1:
            _advance(p, x, h, 0.5 * (u[k] + u[k + 1]), t[k] + 0.5 * h - t[0])
            cuts = 0
        for c in range(cuts):
            middle = t[k] + (c + 0.5) * h
            command, j = interpolate(t, u, middle - shift, j, hold)
            _advance(p, x, h, command, middle - t[0])
        if p[s.FILTER_LAG] > 0.0:
            if dt != filter_step:
                filter_step, filter_decay = dt, math.exp(-dt / p[s.FILTER_LAG])
            ramp = (x[W] - w) / dt * p[s.FILTER_LAG]
            x[FILTERED] = x[W] - ramp + (x[FILTERED] - w + ramp) * filter_decay
        if angle.size > 0:
            x[ANGLE] += (angle[k + 1] - x[ANGLE]) * min(1.0, dt / p[s.ANGLE_TIME])
    return out
