"""Layout of the fast loop's settings and of the rows that it writes, one a tick."""

import math

import numpy as np

from mock_dsp.control.parameters import TICK_S, FastLoopParameters
from mock_dsp.scenario.rig_constants import MotorConstants, RigConstants

_OBSERVER_BANDWIDTH_HZ = 10.0

DRIVE_DTYPE = np.dtype(
    [("pwm_on", np.int64), ("centring_on", np.int64), ("sensor_stuck_ticks", np.int64)]
    + [
        (name, np.float64)
        for name in (
            "centring_gain", "centring_filter", "current_limit", "over_current", "rated_current_squared",
            "i2t_filter", "speed_limit", "travel_min", "travel_max", "flux_current",
            "proportional", "integral", "slip_gain", "rotor_decay", "leakage", "coupling", "emf_gain",
            "pole_pairs", "mutual_inductance", "bus_voltage", "dead_time", "observer_angle", "observer_speed",
        )
    ]
)  # fmt: skip

TRACE_DTYPE = np.dtype(
    [
        ("current_ref_counts", np.int16),
        ("current_counts", np.int16),
        ("position_counts", np.uint16),
        ("phase_a_counts", np.int16),
        ("phase_b_counts", np.int16),
        ("speed_counts", np.int16),
        ("limited", np.bool_),
        ("true_speed_rad_s", np.float64),
        ("true_position_rad", np.float64),
        ("true_torque_nm", np.float64),
        ("true_current_a", np.float64),
    ]
)


def compile_drive(parameters: FastLoopParameters, rig: RigConstants) -> np.ndarray:
    """Turn settings into the constants of the control kernels, shape (1,) of `DRIVE_DTYPE`.

    The controller knows the nameplate, not the motor: hidden effects do not reach this function.
    """
    observer_pole = math.exp(-2.0 * math.pi * _OBSERVER_BANDWIDTH_HZ * TICK_S)
    values: dict[str, float] = {
        "pwm_on": parameters.pwm_on,
        "centring_on": parameters.centring_on,
        "sensor_stuck_ticks": parameters.sensor_stuck_ticks,
        "centring_gain": parameters.centring_gain_a_rad,
        "centring_filter": -math.expm1(-2.0 * math.pi * parameters.centring_bandwidth_hz * TICK_S),
        "current_limit": parameters.current_limit_a,
        "over_current": parameters.over_current_a,
        "rated_current_squared": parameters.rated_current_a**2,
        "i2t_filter": -math.expm1(-TICK_S / parameters.i2t_time_s),
        "speed_limit": parameters.speed_limit_rad_s,
        "travel_min": parameters.travel_min_rad,
        "travel_max": parameters.travel_max_rad,
        "flux_current": parameters.flux_current_a,
        "bus_voltage": rig.inverter.bus_voltage_v,
        "dead_time": rig.inverter.dead_time_s / TICK_S,
        "observer_angle": 1.0 - observer_pole**2,
        "observer_speed": (1.0 - observer_pole) ** 2 / TICK_S,
    }
    values |= _motor_values(rig.motor, 2.0 * math.pi * parameters.current_loop_bandwidth_hz)
    record = np.zeros(1, DRIVE_DTYPE)
    for name, value in values.items():
        record[name] = value
    return record


def _motor_values(motor: MotorConstants, bandwidth_rad_s: float) -> dict[str, float]:
    """Return what the control derives from the nameplate.

    The current controllers cancel the stator's pole: Kp = sigma Ls wc, Ki = (Rs + Rr (Lm/Lr)^2) wc (Novotny
    and Lipo, Vector Control and Dynamics of AC Drives, ch. 7).
    """
    ls, lr, lm = motor.stator_inductance_h, motor.rotor_inductance_h, motor.mutual_inductance_h
    rs, rr = motor.stator_resistance_ohm, motor.rotor_resistance_ohm
    leakage = ls - lm * lm / lr
    return {
        "proportional": leakage * bandwidth_rad_s,
        "integral": (rs + rr * (lm / lr) ** 2) * bandwidth_rad_s,
        "slip_gain": lm * rr / lr,
        "rotor_decay": rr / lr,
        "leakage": leakage,
        "coupling": lm * rr / lr**2,
        "emf_gain": lm / lr,
        "pole_pairs": motor.pole_pairs,
        "mutual_inductance": lm,
    }
