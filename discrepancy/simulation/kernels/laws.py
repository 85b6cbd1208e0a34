"""The laws of the joint as functions of its state: torques, friction levels, and the exact stick-slip step."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from discrepancy.simulation import slots as s

FloatArray = NDArray[np.float64]


@njit(cache=True, error_model="numpy", inline="always")
def interpolate(t: FloatArray, u: FloatArray, at: float, j: int, hold: bool) -> tuple[float, int]:
    """Value of the input at a time, with the pointer `j` moved to its interval."""
    n = t.size
    while j > 0 and t[j] > at:
        j -= 1
    while j < n - 2 and t[j + 1] <= at:
        j += 1
    if at <= t[j]:
        return u[j], j
    if hold or at >= t[j + 1]:
        return (u[j] if at < t[j + 1] else u[j + 1]), j
    return u[j] + (u[j + 1] - u[j]) * (at - t[j]) / (t[j + 1] - t[j]), j


@njit(cache=True, error_model="numpy")
def limit_current(p: FloatArray, u: float) -> float:
    """Send the commanded (or measured) current through sensor error, dead time and limit."""
    if p[s.INPUT_IS_MEASURED] > 0.0:
        u = (u - p[s.SENSOR_OFFSET]) / p[s.SENSOR_GAIN]
    if p[s.DEAD_CURRENT] > 0.0:
        ramp = u / (p[s.DEAD_CURRENT] * p[s.DEAD_WIDTH])
        u -= p[s.DEAD_CURRENT] * min(1.0, max(-1.0, ramp))
    return float(min(p[s.CURRENT_LIMIT], max(-p[s.CURRENT_LIMIT], u)))


@njit(cache=True, error_model="numpy")
def motor_torque(p: FloatArray, current: float, time: float) -> float:
    """Torque of the motor: constant, its drift, and magnetic saturation."""
    torque = p[s.TORQUE_CONSTANT] * current
    if p[s.CONSTANT_DRIFT] != 0.0:
        torque *= 1.0 + p[s.CONSTANT_DRIFT] * -math.expm1(-time / p[s.CONSTANT_DRIFT_TIME])
    if p[s.TORQUE_LIMIT] < s.NO_LIMIT and torque != 0.0:
        # u / (1 + |u|^n)^(1/n) in logarithms: large n is a hard limit and must not overflow.
        n = p[s.TORQUE_LIMIT_EXPONENT]
        power = n * math.log(abs(torque) / p[s.TORQUE_LIMIT])
        torque *= math.exp(-(power if power > 30.0 else math.log1p(math.exp(power))) / n)
    return float(torque)


@njit(cache=True, error_model="numpy")
def spline_torque(p: FloatArray, q: float, w: float, current: float) -> float:
    """Torque on the joint that a curve over angle, speed or current says; constant beyond its ends."""
    x = q if p[s.SPLINE_DRIVER] == s.SPLINE_OVER_ANGLE else w
    if p[s.SPLINE_DRIVER] == s.SPLINE_OVER_CURRENT:
        x = current
    last = int(p[s.SPLINE_COUNT]) - 1
    if x <= p[s.SPLINE_X]:
        return float(p[s.SPLINE_Y])
    for i in range(last):
        if x < p[s.SPLINE_X + i + 1]:
            part = (x - p[s.SPLINE_X + i]) / (p[s.SPLINE_X + i + 1] - p[s.SPLINE_X + i])
            return float(p[s.SPLINE_Y + i] + part * (p[s.SPLINE_Y + i + 1] - p[s.SPLINE_Y + i]))
    return float(p[s.SPLINE_Y + last])


@njit(cache=True, error_model="numpy")
def position_torque(p: FloatArray, q: float, w: float, current: float) -> float:
    """Torque that opposes the motion because of where the joint stands: gravity, end stop, a fitted curve."""
    torque = 0.0
    if p[s.SPLINE_DRIVER] > 0.0:
        torque -= spline_torque(p, q, w, current)
    if p[s.GRAVITY_WAVE] != 0.0:
        a = p[s.GRAVITY_WAVE] * q
        torque += p[s.GRAVITY_SIN] * math.sin(a) + p[s.GRAVITY_COS] * math.cos(a)
    if p[s.STOP_STIFFNESS] > 0.0:
        if q > p[s.STOP_HIGH]:
            torque += max(0.0, p[s.STOP_STIFFNESS] * (q - p[s.STOP_HIGH]) + p[s.STOP_DAMPING] * w)
        elif q < p[s.STOP_LOW]:
            torque += min(0.0, p[s.STOP_STIFFNESS] * (q - p[s.STOP_LOW]) + p[s.STOP_DAMPING] * w)
    return torque


@njit(cache=True, error_model="numpy")
def ripple_torque(p: FloatArray, q: float, current: float) -> float:
    """Torque of cogging or winding harmonics that opposes the motion."""
    if p[s.RIPPLE_WAVE] == 0.0:
        return 0.0
    a = p[s.RIPPLE_WAVE] * q
    ripple = p[s.RIPPLE_SIN] * math.sin(a) + p[s.RIPPLE_COS] * math.cos(a)
    return float(ripple * (current if p[s.RIPPLE_CURRENT] > 0.5 else 1.0))


@njit(cache=True, error_model="numpy")
def dry_level(p: FloatArray, speed: float, direction: float, torque: float) -> float:
    """Level of the dry friction, N m, that opposes motion in `direction` at |speed| under the motor's torque."""
    level = p[s.COULOMB] + (p[s.ASYM_POSITIVE] if direction > 0.0 else p[s.ASYM_NEGATIVE])
    level += p[s.STRIBECK_COULOMB] + p[s.LOAD_FRICTION] * abs(torque)
    if p[s.STRIBECK_EXTRA] != 0.0:
        x = abs(speed) / p[s.STRIBECK_SPEED]
        x = x * x if p[s.STRIBECK_EXPONENT] == 2.0 else x ** p[s.STRIBECK_EXPONENT]
        level += p[s.STRIBECK_EXTRA] * math.exp(-x)
    return float(level)


@njit(cache=True, error_model="numpy")
def has_dry_friction(p: FloatArray) -> bool:
    """Whether any dry friction is on; presliding springs may bring a joint to rest too."""
    dry = p[s.COULOMB] + p[s.ASYM_POSITIVE] + p[s.ASYM_NEGATIVE] + p[s.STRIBECK_COULOMB]
    return bool(dry + p[s.STRIBECK_EXTRA] + p[s.LOAD_FRICTION] + p[s.PRESLIDING_LEVEL] > 0.0)


@njit(cache=True, error_model="numpy")
def viscous_coefficient(p: FloatArray, w: float, time: float) -> float:
    """Viscous coefficient at this time and for this direction of the motion."""
    b = p[s.VISCOUS]
    if p[s.VISCOUS_DRIFT] != 0.0:
        b *= 1.0 + p[s.VISCOUS_DRIFT] * -math.expm1(-time / p[s.VISCOUS_DRIFT_TIME])
    return float(b + (p[s.ASYM_VISCOUS] if w > 0.0 else -p[s.ASYM_VISCOUS]))


@njit(cache=True, error_model="numpy")
def inertia_at(p: FloatArray, q: float) -> tuple[float, float]:
    """Inertia at this angle and the coefficient of its reaction torque, J'(q)/2."""
    inertia = p[s.INERTIA]
    if p[s.INERTIA_WAVE] == 0.0:
        return inertia, 0.0
    a = p[s.INERTIA_WAVE] * q
    sin, cos = math.sin(a), math.cos(a)
    factor = 1.0 + p[s.INERTIA_SIN] * sin + p[s.INERTIA_COS] * cos
    slope = p[s.INERTIA_WAVE] * (p[s.INERTIA_SIN] * cos - p[s.INERTIA_COS] * sin)
    return inertia * max(0.05, factor), 0.5 * inertia * slope * p[s.INERTIA_REACTION]


@njit(cache=True, error_model="numpy")
def slide(
    p: FloatArray, w: float, h: float, drive: float, body: tuple[float, float, float, float, float]
) -> float:
    """Advance the speed by `h` under smooth torque `drive` with exact stick and slip.

    `body` holds inertia, viscous coefficient, motor torque (for load-dependent friction), last acceleration, and which
    part of the joint's dry friction acts on it.
    """
    inertia, viscous, torque, accel, part = body
    half = 0.5 * h * viscous / inertia
    direction = 1.0 if w > 0.0 else -1.0
    if w == 0.0:
        if drive > part * dry_level(p, 0.0, 1.0, torque):
            direction = 1.0
        elif -drive <= part * dry_level(p, 0.0, -1.0, torque):
            return 0.0
    middle = w + 0.5 * h * accel
    if middle * direction < 0.0:
        middle = 0.5 * w
    level = part * dry_level(p, middle, direction, torque)
    new = (w * (1.0 - half) + h * (drive - direction * level) / inertia) / (1.0 + half)
    if new * direction >= 0.0 or w == 0.0:
        return new if new * direction >= 0.0 else 0.0
    rest = h * (1.0 - w / (w - new))
    ahead = part * dry_level(p, 0.0, -direction, torque)
    if -direction * drive <= ahead:
        return 0.0
    return rest * (drive + direction * ahead) / inertia / (1.0 + 0.5 * rest * viscous / inertia)
