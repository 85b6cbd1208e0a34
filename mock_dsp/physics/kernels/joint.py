"""Belt, joint and its friction, all at the motor shaft.

Dry friction is set-valued at rest: a body at rest stays *exactly* at rest while the other torques are below
the static level, and leaves when they exceed it; no smooth function stands for the sign. A sub-step in which
the speed would cross zero is cut at the crossing: there the body either sticks or goes on into the other
direction with the rest of the sub-step. Viscous friction is taken by the trapezoidal rule, so that the linear
joint is exact to second order.
"""

import math

import numpy as np
from numba import njit

from mock_dsp.physics.layout import HYSTERESIS_ELEMENTS, JOINT_LINEAR, JOINT_TWO_BODIES

_STOP_STIFFNESS = 500.0
_STOP_DAMPING = 20.0
_SUM_OF_YIELDS = 0.5 * (HYSTERESIS_ELEMENTS + 1)


@njit(cache=True)
def dry_friction(plant: np.void, angle: float, speed: float, direction: float, drive_torque: float) -> float:
    """Return the level of dry friction against `direction`, N m, not negative.

    At speed 0 this is the static level.
    """
    level: float = plant["coulomb_friction.torque_nm"]
    if direction > 0.0:
        level += plant["asymmetric_coulomb_friction.positive_nm"]
    else:
        level += plant["asymmetric_coulomb_friction.negative_nm"]
    if plant["stribeck_friction.speed_rad_s"] > 0.0:
        slide = plant["stribeck_friction.coulomb_nm"]
        ratio = speed / plant["stribeck_friction.speed_rad_s"]
        level += slide + (plant["stribeck_friction.static_nm"] - slide) * math.exp(-ratio * ratio)
    level += plant["load_dependent_friction.coefficient"] * abs(drive_torque)
    if plant["sticky_spot.torque_nm"] > 0.0:
        share = (angle - plant["sticky_spot.centre_rad"]) / plant["sticky_spot.width_rad"]
        if abs(share) < 0.5:
            level += plant["sticky_spot.torque_nm"] * 0.5 * (1.0 + math.cos(2.0 * math.pi * share))
    return level


@njit(cache=True)
def stop_torque(depth: float, speed_inward: float, stiffness: float, damping: float) -> float:
    """Return the push of an elastic stop, N m; `depth` is how far the body is in it, rad. It never pulls."""
    if depth <= 0.0:
        return 0.0
    return max(0.0, stiffness * depth + damping * speed_inward)


@njit(cache=True)
def stops(plant: np.void, angle: float, speed: float) -> float:
    """Return the torque of the travel's own stops and of the hidden one, N m."""
    travel = plant["travel_stop"]
    torque = stop_torque(-travel - angle, -speed, _STOP_STIFFNESS, _STOP_DAMPING)
    torque -= stop_torque(angle - travel, speed, _STOP_STIFFNESS, _STOP_DAMPING)
    stiffness = plant["end_stop.stiffness_nm_rad"]
    if stiffness > 0.0:
        damping = plant["end_stop.damping_nm_s_rad"]
        torque += stop_torque(plant["end_stop.lower_rad"] - angle, -speed, stiffness, damping)
        torque -= stop_torque(angle - plant["end_stop.upper_rad"], speed, stiffness, damping)
    return torque


@njit(cache=True)
def step_hysteresis(state: np.void, plant: np.void, speed: float, step_s: float) -> float:
    """Advance the Maxwell slip elements and return their torque, N m.

    Element i is a spring that yields at (i+1)/4 of the displacement; all four yield at the full torque.
    """
    displacement = plant["presliding_hysteresis.displacement_rad"]
    if displacement == 0.0:
        return 0.0
    springs = state["hysteresis"]
    stretch = 0.0
    for element in range(HYSTERESIS_ELEMENTS):
        limit = displacement * (element + 1) / HYSTERESIS_ELEMENTS
        springs[element] = min(limit, max(-limit, springs[element] + speed * step_s))
        stretch += springs[element]
    torque: float = plant["presliding_hysteresis.torque_nm"] * stretch / (displacement * _SUM_OF_YIELDS)
    return torque


@njit(cache=True)
def load_torque(plant: np.void, angle: float, speed: float) -> float:
    """Return the smooth torques on the load apart from viscous friction, N m, positive = driving."""
    torque: float = -plant["load_torque_offset.torque_nm"]
    torque -= plant["quadratic_drag.coefficient_nm_s2_rad2"] * speed * abs(speed)
    if plant["gravity_unbalance.amplitude_nm"] > 0.0:
        joint_angle = angle / plant["belt_ratio"] + plant["gravity_unbalance.phase_rad"]
        torque -= plant["gravity_unbalance.amplitude_nm"] * math.sin(joint_angle)
    if plant["eddy_current_brake.critical_speed_rad_s"] > 0.0:
        ratio = speed / plant["eddy_current_brake.critical_speed_rad_s"]
        torque -= 2.0 * plant["eddy_current_brake.peak_nm"] * ratio / (1.0 + ratio * ratio)
    return torque + stops(plant, angle, speed)


@njit(cache=True)
def slide(speed: float, torque: float, inertia: float, viscous: float, step_s: float) -> float:
    """Return the speed after one step under a constant torque and viscous friction."""
    half = 0.5 * step_s * viscous
    return ((inertia - half) * speed + step_s * torque) / (inertia + half)


@njit(cache=True)
def step_load(state: np.void, plant: np.void, drive_torque: float, inertia: float, step_s: float) -> None:
    """Advance the load body by one sub-step, stick and slip included.

    Args:
        state: State of the rig.
        plant: Constants of the rig.
        drive_torque: Torque from motor or belt, N m.
        inertia: Inertia that moves with the load, kg m^2.
        step_s: Sub-step, s.
    """
    speed, angle = state["load_speed"], state["load_angle"]
    torque = drive_torque + load_torque(plant, angle, speed)
    torque -= step_hysteresis(state, plant, speed, step_s)
    if plant["position_dependent_inertia.fraction"] > 0.0:
        joint_angle = angle / plant["belt_ratio"] + plant["position_dependent_inertia.phase_rad"]
        swing = plant["position_dependent_inertia.fraction"] * plant["load_inertia"]
        inertia += swing * math.cos(joint_angle)
        # Lagrange: the change of inertia costs half of J'(angle) w^2 beside J w'.
        torque += 0.5 * swing * math.sin(joint_angle) / plant["belt_ratio"] * speed * speed
    moving = speed if speed != 0.0 else torque
    viscous = state["load_viscous_now"]
    if moving > 0.0:
        viscous += plant["asymmetric_viscous_friction.positive_nm_s_rad"]
    else:
        viscous += plant["asymmetric_viscous_friction.negative_nm_s_rad"]
    direction = 1.0 if moving > 0.0 else -1.0
    level = dry_friction(plant, angle, speed, direction, drive_torque)
    after = slide(speed, torque - direction * level, inertia, viscous, step_s)
    if level > 0.0 and after * direction <= 0.0:
        after = reverse_or_stick(plant, state, torque, drive_torque, (inertia, after, step_s))
    state["load_speed"] = after
    state["load_angle"] = angle + 0.5 * step_s * (speed + after)


@njit(cache=True)
def reverse_or_stick(
    plant: np.void, state: np.void, torque: float, drive_torque: float, crossing: tuple[float, float, float]
) -> float:
    """Return the speed at the end of a sub-step in which the load came to rest.

    Args:
        plant: Constants of the rig.
        state: State of the rig before the sub-step.
        torque: All torques but dry friction, N m.
        drive_torque: Transmitted torque, N m.
        crossing: Inertia (kg m^2), the speed that would have been reached (rad/s), sub-step (s).
    """
    inertia, after, step_s = crossing
    speed: float = state["load_speed"]
    direction = 1.0 if torque > 0.0 else -1.0
    static = dry_friction(plant, state["load_angle"], 0.0, direction, drive_torque)
    if speed == 0.0 or abs(torque) <= static:
        return 0.0
    rest_of_step = step_s * after / (after - speed)
    return rest_of_step * (torque - direction * static) / inertia


@njit(cache=True)
def shaft_torque(state: np.void, plant: np.void, motor_torque: float, step_s: float) -> float:
    """Return the torque that belt and teeth carry from motor to load in the middle of a sub-step, N m.

    In the gap it is 0. The twist is taken half a step ahead (position Verlet: no energy drift), and so is the
    rate at which it changes, solved for the damper's own action on the motor; the load is 100 times heavier.
    """
    stiffness, damping, half_gap = plant["shaft_stiffness"], plant["shaft_damping"], plant["shaft_half_gap"]
    half = 0.5 * step_s
    rate = state["motor_speed"] - state["load_speed"]
    twist = state["motor_angle"] - state["load_angle"] + half * rate
    stretch = twist - min(half_gap, max(-half_gap, twist))
    if half_gap > 0.0 and stretch == 0.0:
        return 0.0
    spring = stiffness * stretch
    yielding = half / plant["motor_inertia"]
    net_torque = motor_torque - plant["motor_viscous"] * state["motor_speed"] - spring
    torque: float = spring + damping * (rate + yielding * net_torque) / (1.0 + yielding * damping)
    if half_gap == 0.0:
        return torque
    # Teeth push and never pull.
    return max(0.0, torque) if stretch > 0.0 else min(0.0, torque)


@njit(cache=True)
def step_joint(state: np.void, plant: np.void, torque: float, step_s: float) -> None:
    """Advance motor shaft and joint by one sub-step under the torque of the motor, N m."""
    mode = plant["joint_mode"]
    angle = state["motor_angle"]
    total_inertia = plant["motor_inertia"] + plant["load_inertia"]
    if mode == JOINT_LINEAR and abs(angle) < plant["travel_stop"]:
        speed = state["motor_speed"]
        after = slide(
            speed, torque, total_inertia, plant["motor_viscous"] + state["load_viscous_now"], step_s
        )
        state["motor_speed"] = after
        state["motor_angle"] = angle + 0.5 * step_s * (speed + after)
        state["load_speed"], state["load_angle"] = state["motor_speed"], state["motor_angle"]
        return
    if plant["torque_ripple.amplitude_nm"] > 0.0:
        ripple = plant["torque_ripple.harmonic"] * angle + plant["torque_ripple.phase_rad"]
        torque += plant["torque_ripple.amplitude_nm"] * math.sin(ripple)
    if mode == JOINT_TWO_BODIES:
        carried = shaft_torque(state, plant, torque, step_s)
        speed = state["motor_speed"]
        after = slide(speed, torque - carried, plant["motor_inertia"], plant["motor_viscous"], step_s)
        step_load(state, plant, carried, plant["load_inertia"], step_s)
        state["motor_speed"] = after
        state["motor_angle"] = angle + 0.5 * step_s * (speed + after)
        return
    step_load(state, plant, torque - plant["motor_viscous"] * state["load_speed"], total_inertia, step_s)
    state["motor_speed"], state["motor_angle"] = state["load_speed"], state["load_angle"]
