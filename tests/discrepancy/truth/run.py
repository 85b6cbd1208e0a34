"""Integrate the second truth and sample it as an instrument would (hold, mean or instant)."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from tests.discrepancy.truth.joint import Joint, Wave, drive_current, dry_level, motor_torque, smooth_load

FloatArray = NDArray[np.float64]
W, Q, CURRENT, Y, WL, TWIST, Z = range(7)
_TINY = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Trace:
    """What happened, on a fine grid: time, true current, speed, angle, speed as the sensor shows it."""

    time_s: FloatArray
    current: FloatArray
    speed: FloatArray
    angle: FloatArray
    sensed: FloatArray


def _inertia(joint: Joint, q: float) -> tuple[float, float]:
    arm = joint.has("position_dependent_inertia")
    if not arm:
        return joint.inertia, 0.0
    phase = arm["wave"] * q + arm["phase"]
    return (
        joint.inertia * (1.0 + arm["part"] * math.cos(phase)),
        -0.5 * joint.inertia * arm["part"] * arm["wave"] * math.sin(phase),
    )


def _shaft(joint: Joint, x: FloatArray) -> float:
    belt, play = joint.has("belt_compliance"), joint.has("backlash")
    if belt:
        return belt["stiffness"] * float(x[TWIST]) + belt["damping"] * float(x[W] - x[WL])
    if not play:
        return 0.0
    twist, half = float(x[TWIST]), 0.5 * play["gap"]
    if abs(twist) <= half:
        return 0.0
    wound = twist - math.copysign(half, twist)
    torque = play["stiffness"] * wound + play["damping"] * float(x[W] - x[WL])
    return torque if torque * wound > 0.0 else 0.0


def _forces(joint: Joint, u: Wave, t: float, x: FloatArray) -> tuple[float, float, float, float]:
    """Return drive (all but dry friction), motor torque, inertia of the motor's side and of the load's side."""
    w, q = float(x[W]), float(x[Q])
    lag = joint.has("current_loop_lag")
    torque = motor_torque(joint, float(x[CURRENT]) if lag else drive_current(joint, u, t), t)
    inertia, reaction = _inertia(joint, q)
    drive = torque - reaction * w * w
    two = joint.has("belt_compliance") or joint.has("backlash")
    if two:
        part = two["load_part"]
        drive -= _shaft(joint, x) + (smooth_load(joint, t, w, q) - part * joint.viscous * w)
        return drive, torque, inertia * (1.0 - part), inertia * part
    drive -= smooth_load(joint, t, w, q)
    hysteresis = joint.has("presliding_hysteresis")
    if hysteresis:
        drive -= hysteresis["stiffness"] * float(x[Z])
    return drive, torque, inertia, 0.0


def _rates(joint: Joint, u: Wave, t: float, x: FloatArray, mode: int) -> FloatArray:
    rates = np.zeros(7)
    w = float(x[W])
    drive, torque, inertia, load = _forces(joint, u, t, x)
    if mode != 2:
        friction = mode * dry_level(joint, w, float(mode), torque) if mode else 0.0
        rates[W] = (drive - friction) / inertia
    rates[Q] = w
    lag = joint.has("current_loop_lag")
    if lag:
        rates[CURRENT] = (drive_current(joint, u, t) - x[CURRENT]) / lag["time"]
    slow = joint.has("speed_filter_lag")
    if slow:
        rates[Y] = (w - x[Y]) / slow["time"]
    if load:
        part = load / (load + inertia)
        rates[WL] = (_shaft(joint, x) - part * joint.viscous * x[WL]) / load
        rates[TWIST] = w - x[WL]
    hysteresis = joint.has("presliding_hysteresis")
    if hysteresis:
        rates[Z] = w - abs(w) * hysteresis["stiffness"] * x[Z] / hysteresis["level"]
    return rates


_DRY = ("coulomb_friction", "asymmetric_coulomb_friction", "stribeck_friction", "load_dependent_friction")


def _next_mode(joint: Joint, u: Wave, t: float, x: FloatArray) -> int:
    """Return 1 or -1 (sliding), or 2 (stuck), for a joint that stands."""
    drive, torque, _, _ = _forces(joint, u, t, x)
    if drive > dry_level(joint, 0.0, 1.0, torque):
        return 1
    return -1 if -drive > dry_level(joint, 0.0, -1.0, torque) else 2


def integrate(joint: Joint, u: Wave, duration_s: float, grid_s: float) -> Trace:
    """Integrate from rest and return the motion on a grid of `grid_s`."""
    grid = np.arange(round(duration_s / grid_s) + 1, dtype=np.float64) * grid_s
    dry = any(name in joint.hidden for name in _DRY)
    x, t, at = np.zeros(7), 0.0, 0
    x[CURRENT] = drive_current(joint, u, 0.0)
    states = np.zeros((grid.size, 7))
    mode = _next_mode(joint, u, 0.0, x) if dry else 0
    while t < grid[-1] - 1e-12:
        solution: Any = solve_ivp(
            lambda now, y, m=mode: _rates(joint, u, now, y, m), (t, grid[-1]), x, method="LSODA",
            events=_mode_ends(joint, u, mode) if dry else None,
            rtol=1e-7, atol=1e-9, max_step=0.01, dense_output=True,
        )  # fmt: skip
        t = float(solution.t[-1])
        upto = int(np.searchsorted(grid, t + 1e-12))
        if upto > at:
            states[at:upto] = solution.sol(grid[at:upto]).T
            at = upto
        x = solution.y[:, -1].copy()
        if solution.status == 1:
            x[W] = 0.0
            # A root just before a jump of the input would be found for ever: decide a nanosecond later.
            t += 1e-9
            mode = _next_mode(joint, u, t, x)
            if mode != 2:
                x[W] = 1e-8 * mode
    return _observe(joint, u, grid, states)


def _mode_ends(joint: Joint, u: Wave, mode: int) -> Any:  # scipy wants attributes on a function
    """Return the event that ends sliding in direction `mode`, or sticking (2)."""

    def slide_ends(_t: float, y: FloatArray) -> float:
        return float(y[W]) * mode + _TINY

    def stick_ends(now: float, y: FloatArray) -> float:
        drive, torque, _, _ = _forces(joint, u, now, y)
        forward, backward = dry_level(joint, 0.0, 1.0, torque), dry_level(joint, 0.0, -1.0, torque)
        return min(forward - drive, backward + drive) + _TINY

    event: Any = stick_ends if mode == 2 else slide_ends
    event.terminal, event.direction = True, -1.0
    return event


def _observe(joint: Joint, u: Wave, grid: FloatArray, states: FloatArray) -> Trace:
    """Return the motion with the speed as the sensor shows it."""
    lag = joint.has("current_loop_lag")
    sensed = states[:, Y] if joint.has("speed_filter_lag") else states[:, W]
    pot = joint.has("potentiometer_nonlinearity")
    if pot:
        sensed = sensed * (1.0 + pot["part"] * np.cos(pot["wave"] * states[:, Q] + pot["phase"]))
    if joint.has("rectified_speed_sensor"):
        sensed = np.abs(sensed)
    return Trace(
        time_s=grid,
        current=states[:, CURRENT] if lag else np.array([drive_current(joint, u, now) for now in grid]),
        speed=states[:, W],
        angle=states[:, Q],
        sensed=sensed,
    )


def sample(values: FloatArray, every: int, how: str) -> FloatArray:
    """Take every so many grid points: `instant`, or the `mean` over the interval that ends there."""
    if how == "instant":
        return values[::every]
    means = np.concatenate([[values[0]], values[1:]]).cumsum()
    rows = np.arange(0, values.size, every)
    return np.array([values[0], *((means[b] - means[a]) / (b - a) for a, b in pairwise(rows))])
