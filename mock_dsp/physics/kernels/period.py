"""One PWM period of the machine: 20 us sub-steps of inverter, motor and joint."""

import math

import numpy as np
from numba import njit

from mock_dsp.physics.kernels.inverter import (
    bridge_voltage,
    current_sign,
    diode_voltage,
    on_share,
    pulse_edges,
)
from mock_dsp.physics.kernels.joint import step_joint
from mock_dsp.physics.kernels.motor import renew_heat, stator_current, step_motor

_HALF_SQRT3 = 0.5 * math.sqrt(3.0)


@njit(cache=True)
def renew_slow(state: np.void, plant: np.void, tick_s: float) -> None:
    """Renew what changes over seconds with the bridge on: heat, viscous friction and torque constant."""
    state["warm_ticks"] += 1
    time_s = state["warm_ticks"] * tick_s
    renew_heat(state, plant, stator_current(state, plant), tick_s)
    viscous_tau = plant["viscous_friction_drift.time_constant_s"]
    if viscous_tau > 0.0:
        change = plant["viscous_friction_drift.fraction"] * (1.0 - math.exp(-time_s / viscous_tau))
        state["load_viscous_now"] = plant["load_viscous"] * (1.0 + change)
    torque_tau = plant["torque_constant_drift.time_constant_s"]
    if torque_tau > 0.0:
        change = plant["torque_constant_drift.fraction"] * (1.0 - math.exp(-time_s / torque_tau))
        state["torque_factor"] = 1.0 + change


@njit(cache=True)
def cool_down(state: np.void, plant: np.void) -> None:
    """Forget all warming up, so that each run begins cold, however long the pause before it."""
    state["warm_ticks"] = 0
    state["heat"] = 0.0
    state["rotor_resistance_now"] = plant["rotor_resistance"]
    state["load_viscous_now"] = plant["load_viscous"]
    state["torque_factor"] = 1.0


@njit(cache=True)
def leg_edges(
    state: np.void, plant: np.void, dead_time: float
) -> tuple[tuple[float, float], tuple[float, float], tuple[float, float]]:
    """Return the edges of the three legs for the present directions of the currents."""
    alpha, beta = stator_current(state, plant)
    b = _HALF_SQRT3 * beta - 0.5 * alpha
    return (
        pulse_edges(state["duty_a"], current_sign(alpha), dead_time),
        pulse_edges(state["duty_b"], current_sign(b), dead_time),
        pulse_edges(state["duty_c"], current_sign(-alpha - b), dead_time),
    )


@njit(cache=True)
def step_machine(state: np.void, plant: np.void, voltage: tuple[float, float], step_s: float) -> None:
    """Advance motor and joint by one sub-step under a stator voltage (alpha, beta), V."""
    torque = state["torque_factor"] * step_motor(state, plant, voltage[0], voltage[1], step_s)
    limit = plant["torque_saturation.limit_nm"]
    if limit > 0.0:
        torque = min(limit, max(-limit, torque))
    step_joint(state, plant, torque, step_s)


@njit(cache=True)
def run_period_switching(state: np.void, plant: np.void, tick_s: float) -> None:
    """Advance one PWM period with the duties in the state.

    Rising edges lie in the first half and falling ones in the second: each half takes the directions
    of the currents at its own start.
    """
    substeps = plant["substeps"]
    share = 1.0 / substeps
    step_s = tick_s * share
    dead_time = (plant["dead_time"] + plant["inverter_dead_time.extra_s"]) / tick_s
    for half in range(2):
        edges_a, edges_b, edges_c = leg_edges(state, plant, dead_time)
        for index in range(half * substeps // 2, (half + 1) * substeps // 2):
            start, stop = index * share, (index + 1) * share
            on_a, on_b, on_c = (
                on_share(edges_a, start, stop),
                on_share(edges_b, start, stop),
                on_share(edges_c, start, stop),
            )
            step_machine(state, plant, bridge_voltage(plant, on_a, on_b, on_c), step_s)


@njit(cache=True)
def run_period_coasting(state: np.void, plant: np.void, tick_s: float) -> None:
    """Advance one PWM period with all switches open."""
    substeps = plant["substeps"]
    step_s = tick_s / substeps
    for _ in range(substeps):
        step_machine(state, plant, diode_voltage(plant, stator_current(state, plant)), step_s)
