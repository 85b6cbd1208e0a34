"""Hall sensors and potentiometer, down to the counts that the controller's program sees.

Currents: +-4 A on a 12-bit converter, left-justified in 16 bit. Position: a wiper over ten turns, 16
conversions of 12 bit summed to 16 bit. With conversion noise of half an LSB or more the sum is that of 16
dithered roundings: mean 16 x, variance 16 (noise^2 + 1/12), which one Gaussian number gives at a sixteenth
of the cost. Without noise all 16 conversions agree, and the sum moves in steps of 16.
"""

import math

import numpy as np
from numba import njit

from mock_dsp.physics.kernels.motor import stator_current

_ADC_STEP_A = 2.0**-9
_ADC_LEFT_SHIFT = 16
_ADC_HALF_RANGE = 2048
_HALF_SQRT3 = 0.5 * math.sqrt(3.0)
_TRAVEL_RAD = 20.0 * math.pi
_TRAVEL_COUNTS = 65536.0


@njit(cache=True)
def convert_current(current_a: float) -> int:
    """Return the converter's reading of a phase current, 2^-13 A per count."""
    steps = math.floor(current_a / _ADC_STEP_A + 0.5)
    return int(min(_ADC_HALF_RANGE - 1, max(-_ADC_HALF_RANGE, steps))) * _ADC_LEFT_SHIFT


@njit(cache=True)
def read_currents(state: np.void, plant: np.void, noise: np.ndarray) -> None:
    """Sample both Hall sensors at the start of a PWM period, where the ripple passes through zero."""
    alpha, beta = stator_current(state, plant)
    tick = state["tick"]
    gain = plant["hall_gain"]
    phase_a = gain * alpha + plant["current_sensor_offset.hall_offset_phase_a_a"]
    phase_b = gain * (_HALF_SQRT3 * beta - 0.5 * alpha) + plant["current_sensor_offset.hall_offset_phase_b_a"]
    if plant["hall_from"] <= tick < plant["hall_to"]:
        phase_a += plant["hall_shift_a"]
    if plant["surge_from"] <= tick < plant["surge_to"]:
        phase_a += plant["surge_a"]
    state["phase_a_counts"] = convert_current(phase_a + plant["current_noise"] * noise[0])
    state["phase_b_counts"] = convert_current(phase_b + plant["current_noise"] * noise[1])


@njit(cache=True)
def read_potentiometer(state: np.void, plant: np.void, noise: np.ndarray) -> None:
    """Sample the potentiometer and count how often the reading has repeated itself."""
    angle = state["motor_angle"]
    if plant["potentiometer_nonlinearity.amplitude_rad"] > 0.0:
        turn = 2.0 * math.pi * plant["potentiometer_nonlinearity.cycles"] / _TRAVEL_RAD
        phase = turn * angle + plant["potentiometer_nonlinearity.phase_rad"]
        angle += plant["potentiometer_nonlinearity.amplitude_rad"] * math.sin(phase)
    state["wiper"] += plant["wiper_gain"] * (angle - state["wiper"])
    if plant["stuck_from"] <= state["tick"] < plant["stuck_to"]:
        state["repeats"] += 1
        return
    exact = _TRAVEL_COUNTS * (0.5 + state["wiper"] / _TRAVEL_RAD)
    step = plant["potentiometer_step_counts"]
    noisy = exact + plant["potentiometer_noise_counts"] * noise[2]
    counts = int(min(_TRAVEL_COUNTS - 1.0, max(0.0, step * math.floor(noisy / step + 0.5))))
    state["repeats"] = state["repeats"] + 1 if counts == state["position_counts"] else 0
    state["position_counts"] = counts
