"""A second truth: the hidden joint written by other means than the workflow's own simulation.

Integrated by scipy's LSODA between events; dry friction is a Coulomb automaton (slide forward, slide backward,
stuck) whose
switches are root-finding events; parameters, sampling and noise are drawn here. Nothing of the package under test is
imported.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Wave = Callable[[float], float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Joint:
    """The hidden joint: J dw/dt = Kt i - B w - what `hidden` adds.

    Attributes:
        hidden: effect id to its parameters, in the truth's own names.
    """

    inertia: float = 0.4
    viscous: float = 0.8
    constant: float = 1.0
    hidden: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    def has(self, name: str) -> Mapping[str, float] | None:
        """Return the parameters of a hidden effect."""
        return self.hidden.get(name)


def drive_current(joint: Joint, u: Wave, t: float) -> float:
    """Return the commanded current after dead time, limit and delay (not lag), at time t."""
    delay = joint.has("transport_delay")
    value = u(t - delay["delay"]) if delay else u(t)
    dead = joint.has("inverter_dead_time")
    if dead:
        value = math.copysign(max(abs(value) - dead["lost"], 0.0), value)
    limit = joint.has("current_saturation")
    return max(-limit["limit"], min(limit["limit"], value)) if limit else value


def motor_torque(joint: Joint, current: float, t: float) -> float:
    """Return the torque that the motor makes of a current."""
    torque = joint.constant * current
    warm = joint.has("torque_constant_drift")
    if warm:
        torque *= 1.0 + warm["change"] * (1.0 - math.exp(-t / warm["time"]))
    limit = joint.has("torque_saturation")
    return limit["limit"] * math.tanh(torque / limit["limit"]) if limit else torque


def smooth_load(joint: Joint, t: float, w: float, q: float) -> float:
    """Return all torques but dry friction that oppose the motion."""
    b = joint.viscous
    warm = joint.has("viscous_friction_drift")
    if warm:
        b *= 1.0 + warm["change"] * (1.0 - math.exp(-t / warm["time"]))
    skew = joint.has("asymmetric_viscous_friction")
    if skew:
        b *= 1.0 + math.copysign(skew["skew"], w)
    torque = b * w
    for name, law in _LOADS.items():
        values = joint.has(name)
        if values:
            torque += law(values, w, q)
    return torque


def _end_stop(v: Mapping[str, float], w: float, q: float) -> float:
    over = q - v["angle"]
    return max(0.0, v["stiffness"] * over + v["damping"] * w) if over > 0.0 else 0.0


_LOADS: dict[str, Callable[[Mapping[str, float], float, float], float]] = {
    "quadratic_drag": lambda v, w, q: v["c"] * w * abs(w),
    "cubic_drag": lambda v, w, q: v["c"] * w**3,
    "load_torque_offset": lambda v, w, q: v["torque"],
    "gravity_unbalance": lambda v, w, q: v["torque"] * math.sin(q * v["wave"] + v["phase"]),
    "torque_ripple": lambda v, w, q: v["torque"] * math.sin(q * v["wave"] + v["phase"]),
    "end_stop": _end_stop,
    "eddy_brake": lambda v, w, q: v["peak"] * 2.0 * (w / v["speed"]) / (1.0 + (w / v["speed"]) ** 2),
    "spring": lambda v, w, q: v["k"] * q,
}


def dry_level(joint: Joint, w: float, sign: float, torque: float) -> float:
    """Return the level of dry friction against motion in direction `sign`."""
    level = 0.0
    coulomb = joint.has("coulomb_friction")
    if coulomb:
        level += coulomb["level"]
    skew = joint.has("asymmetric_coulomb_friction")
    if skew:
        level += skew["forward"] if sign > 0.0 else skew["backward"]
    stribeck = joint.has("stribeck_friction")
    if stribeck:
        fall = math.exp(-((abs(w) / stribeck["speed"]) ** 2))
        level += stribeck["level"] + (stribeck["static"] - stribeck["level"]) * fall
    load = joint.has("load_dependent_friction")
    if load:
        level += load["mu"] * abs(torque)
    return level
