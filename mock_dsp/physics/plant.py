"""Turn a scenario into the constant record and the initial state that the kernels take."""

import math

import numpy as np

from mock_dsp.control.parameters import POSITION_COUNTS, TICK_S
from mock_dsp.physics.kernels.period import cool_down
from mock_dsp.physics.layout import (
    JOINT_LINEAR,
    JOINT_RIGID,
    JOINT_TWO_BODIES,
    PLANT_DTYPE,
    STATE_DTYPE,
)
from mock_dsp.scenario.effects import EFFECTS, Port
from mock_dsp.scenario.faults import FaultName
from mock_dsp.scenario.rig_constants import RigConstants
from mock_dsp.scenario.schema import Fault, Scenario

SUBSTEPS = 20
_CONVERSIONS = 16
_FOREVER = 2**62
_SURGE_A = 3.9
_SURGE_S = 0.01
# These act on the current, on the sensors, or through slow factors: the joint itself stays linear.
_LINEAR_JOINT_EFFECTS = frozenset({"viscous_friction_drift", "torque_saturation", "torque_constant_drift"})
_SHAFT_EFFECTS = frozenset({"backlash", "belt_compliance"})


def compile_plant(scenario: Scenario, substeps: int = SUBSTEPS) -> np.ndarray:
    """Return the constants of the machine, shape (1,) of `PLANT_DTYPE`.

    Args:
        scenario: Validated scenario.
        substeps: Sub-steps in a PWM period, even; 20 makes them 20 us.
    """
    effects = {effect.id: effect.complete_parameters for effect in scenario.effects}
    values: dict[str, float] = {
        f"{effect_id}.{name}": value
        for effect_id, numbers in effects.items()
        for name, value in numbers.items()
    }
    values |= _machine_values(scenario.rig)
    values |= _sensor_values(scenario.rig, effects)
    values |= _shaft_values(effects)
    values |= _fault_values(scenario.faults)
    values |= {
        "substeps": substeps,
        "joint_mode": _joint_mode(frozenset(effects)),
        "delay_ticks": round(effects.get("transport_delay", {}).get("delay_s", 0.0) / TICK_S),
        "reference_lag_gain": _lag_gain(effects.get("current_loop_lag", {})),
        "rectified_speed": "rectified_speed_sensor" in effects,
    }
    record = np.zeros(1, PLANT_DTYPE)
    for name, value in values.items():
        record[name] = value
    return record


def initial_state(plant: np.ndarray, position_rad: float) -> np.ndarray:
    """Return the machine at rest and cold at `position_rad`, shape (1,) of `STATE_DTYPE`."""
    state = np.zeros(1, STATE_DTYPE)
    for name in ("motor_angle", "load_angle", "wiper", "observed_angle"):
        state[name] = position_rad
    for name in ("duty_a", "duty_b", "duty_c"):
        state[name] = 0.5
    cool_down(state[0], plant[0])
    state["position_counts"] = round(POSITION_COUNTS * (0.5 + position_rad / (20.0 * math.pi)))
    return state


def _machine_values(rig: RigConstants) -> dict[str, float]:
    motor, mechanics = rig.motor, rig.mechanics
    ls, lr, lm = motor.stator_inductance_h, motor.rotor_inductance_h, motor.mutual_inductance_h
    ratio_squared = mechanics.belt_ratio**2
    return {
        "stator_resistance": motor.stator_resistance_ohm,
        "rotor_resistance": motor.rotor_resistance_ohm,
        "stator_inductance": ls,
        "rotor_inductance": lr,
        "mutual_inductance": lm,
        "determinant": ls * lr - lm * lm,
        "pole_pairs": motor.pole_pairs,
        "rated_current_squared": motor.rated_current_a**2,
        "motor_inertia": motor.inertia_kg_m2 + mechanics.pulley_inertia_kg_m2,
        "motor_viscous": motor.viscous_friction_nm_s_rad + mechanics.pulley_viscous_friction_nm_s_rad,
        "load_inertia": mechanics.joint_inertia_kg_m2 / ratio_squared,
        "load_viscous": mechanics.joint_viscous_friction_nm_s_rad / ratio_squared,
        "belt_ratio": mechanics.belt_ratio,
        "travel_stop": mechanics.travel_stop_rad,
        "bus_voltage": rig.inverter.bus_voltage_v,
        "dead_time": rig.inverter.dead_time_s,
    }


def _sensor_values(rig: RigConstants, effects: dict[str, dict[str, float]]) -> dict[str, float]:
    noise_lsb = rig.sensors.potentiometer_noise_lsb
    gain = effects.get("current_sensor_gain", {})
    dithered = noise_lsb > 0.0
    return {
        "current_noise": rig.sensors.current_noise_a,
        "potentiometer_noise_counts": math.sqrt(_CONVERSIONS * (noise_lsb**2 + 1.0 / 12.0))
        if dithered
        else 0.0,
        "potentiometer_step_counts": 1.0 if dithered else float(_CONVERSIONS),
        "hall_gain": gain.get("hall_gain", 1.0),
        "monitor_gain": gain.get("monitor_gain", 1.0),
        "wiper_gain": _lag_gain(effects.get("speed_filter_lag", {})),
    }


def _shaft_values(effects: dict[str, dict[str, float]]) -> dict[str, float]:
    """Belt and play together make one shaft: the belt's spring, the play's gap."""
    play = effects.get("backlash", {})
    spring = effects.get("belt_compliance", play)
    return {
        "shaft_stiffness": spring.get("stiffness_nm_rad", 0.0),
        "shaft_damping": spring.get("damping_nm_s_rad", 0.0),
        "shaft_half_gap": 0.5 * play.get("gap_rad", 0.0),
    }


def _joint_mode(ids: frozenset[str]) -> int:
    if ids & _SHAFT_EFFECTS:
        return JOINT_TWO_BODIES
    on_the_joint = {effect_id for effect_id in ids if EFFECTS[effect_id].port is Port.TORQUE}
    return JOINT_RIGID if on_the_joint - _LINEAR_JOINT_EFFECTS else JOINT_LINEAR


def _lag_gain(parameters: dict[str, float]) -> float:
    """Return the gain of a first-order lag stepped once a tick; 1 without a lag."""
    if not parameters:
        return 1.0
    return -math.expm1(-TICK_S / parameters["time_constant_s"])


def _fault_values(faults: tuple[Fault, ...]) -> dict[str, float]:
    """Return the windows of the sensor faults; the other faults are not the fast loop's business."""
    values: dict[str, float] = {}
    for fault in faults:
        start = round((fault.at_s or 0.0) / TICK_S)
        end = _FOREVER if fault.duration_s is None else start + max(1, round(fault.duration_s / TICK_S))
        if fault.name is FaultName.STUCK_SENSOR:
            values |= {"stuck_from": start, "stuck_to": end}
        elif fault.name is FaultName.HALL_OFFSET:
            values |= {"hall_from": start, "hall_to": end, "hall_shift_a": fault.magnitude or 0.0}
        elif fault.name is FaultName.OVER_CURRENT:
            surge_end = start + round((fault.duration_s or _SURGE_S) / TICK_S)
            surge = _SURGE_A if fault.magnitude is None else fault.magnitude
            values |= {"surge_from": start, "surge_to": max(start + 1, surge_end), "surge_a": surge}
    return values
