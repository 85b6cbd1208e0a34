"""The PWM interrupt: sample, refer, control, watch; then the machine runs for one period.

Row k of the trace holds what the program knows at tick k: the reference it commands, and currents and
position as sampled at the start of period k.
"""

import math

import numpy as np
from numba import njit

from daq.protocol.codes import FaultBit
from mock_dsp.control.kernels.currents import (
    control_currents,
    measured_angle,
    observe_shaft,
    park_currents,
    release_bridge,
)
from mock_dsp.control.parameters import CURRENT_SCALE_A, POSITION_COUNTS, SPEED_SCALE_RAD_S, TICK_S
from mock_dsp.physics.kernels.period import cool_down, renew_slow, run_period_coasting, run_period_switching
from mock_dsp.physics.kernels.sensors import read_currents, read_potentiometer
from mock_dsp.physics.layout import DELAY_SLOTS

_I16_MAX = 32767.0
_OVER_CURRENT = 1 << FaultBit.OVER_CURRENT
_OVER_SPEED = 1 << FaultBit.OVER_SPEED
_TRAVEL = 1 << FaultBit.TRAVEL
_I2T = 1 << FaultBit.I2T
_SENSOR = 1 << FaultBit.SENSOR


@njit(cache=True)
def to_counts(value: float, scale: float) -> int:
    """Round to counts of `scale`, saturated to 16 bit."""
    return int(min(_I16_MAX, max(-_I16_MAX, math.floor(value / scale + 0.5))))


@njit(cache=True)
def centre_joint(state: np.void, drive: np.void, weight: float) -> float:
    """Return the centring loop's current, A: gain on the slowly low-passed position, faded by `weight`."""
    if not drive["centring_on"]:
        state["centring_position"] = measured_angle(state)
        return 0.0
    position: float = state["centring_position"]
    position += drive["centring_filter"] * (measured_angle(state) - position)
    state["centring_position"] = position
    gain: float = drive["centring_gain"]
    return -gain * position * weight


@njit(cache=True)
def follow_reference(state: np.void, plant: np.void, reference_a: float) -> float:
    """Return the reference that reaches the current loop: late, slow or limited if such an effect is on."""
    line = state["delay_line"]
    tick = state["tick"]
    line[tick % DELAY_SLOTS] = reference_a
    delayed = line[(tick - plant["delay_ticks"]) % DELAY_SLOTS]
    lagged: float = state["lagged_reference"]
    lagged += plant["reference_lag_gain"] * (delayed - lagged)
    state["lagged_reference"] = lagged
    limit: float = plant["current_saturation.limit_a"]
    return min(limit, max(-limit, lagged)) if limit > 0.0 else lagged


@njit(cache=True)
def watch_limits(state: np.void, drive: np.void, measured: tuple[float, float], speed: float) -> int:
    """Return the violated limits as bits, numbered as `daq.protocol.codes.FaultBit`."""
    heat = 0.5 * (measured[0] ** 2 + measured[1] ** 2) / drive["rated_current_squared"]
    state["i2t_heat"] += drive["i2t_filter"] * (heat - state["i2t_heat"])
    limit = drive["over_current"]
    a = CURRENT_SCALE_A * state["phase_a_counts"]
    b = CURRENT_SCALE_A * state["phase_b_counts"]
    counts = state["position_counts"]
    angle = measured_angle(state)
    bits = 0
    if max(abs(a), abs(b), abs(a + b)) > limit:
        bits |= _OVER_CURRENT
    if abs(speed) > drive["speed_limit"]:
        bits |= _OVER_SPEED
    if angle < drive["travel_min"] or angle > drive["travel_max"]:
        bits |= _TRAVEL
    if state["i2t_heat"] > 1.0:
        bits |= _I2T
    stuck = drive["sensor_stuck_ticks"]
    if counts <= 0 or counts >= POSITION_COUNTS - 1 or 0 < stuck <= state["repeats"]:
        bits |= _SENSOR
    return bits


@njit(cache=True)
def write_readings(state: np.void, plant: np.void, row: np.void, i_q: float) -> None:
    """Write the position, and the currents as the monitoring channel shows them."""
    gain = plant["monitor_gain"]
    shown_q = gain * i_q + plant["current_sensor_offset.monitor_offset_a"]
    row["current_counts"] = to_counts(shown_q, CURRENT_SCALE_A)
    row["phase_a_counts"] = to_counts(gain * state["phase_a_counts"], 1.0)
    row["phase_b_counts"] = to_counts(gain * state["phase_b_counts"], 1.0)
    row["position_counts"] = state["position_counts"]


@njit(cache=True)
def write_truth(state: np.void, plant: np.void, row: np.void) -> None:
    """Write what no sensor shows: for tests and for judging speed filters."""
    ra, rb = state["rotor_alpha"], state["rotor_beta"]
    sa, sb = state["stator_alpha"], state["stator_beta"]
    cross = (ra * sb - rb * sa) / plant["determinant"]
    flux = math.sqrt(ra * ra + rb * rb)
    row["true_speed_rad_s"] = state["motor_speed"]
    row["true_position_rad"] = state["motor_angle"]
    row["true_torque_nm"] = (
        1.5 * plant["pole_pairs"] * plant["mutual_inductance"] * state["torque_factor"] * cross
    )
    row["true_current_a"] = plant["rotor_inductance"] * cross / max(flux, 1e-9)


@njit(cache=True)
def interrupt(
    state: np.void,
    plant: np.void,
    drive: np.void,
    command: tuple[float, float],
    noise: np.ndarray,
    row: np.void,
) -> int:
    """Run the program of one PWM interrupt, write its row, and return the violated limits as bits.

    `command` is the reference, A, and the weight of the centring loop, 0..1.
    """
    read_currents(state, plant, noise)
    read_potentiometer(state, plant, noise)
    observe_shaft(state, drive)
    speed = abs(state["observed_speed"]) if plant["rectified_speed"] else state["observed_speed"]
    limit = drive["current_limit"]
    wanted = command[0] + centre_joint(state, drive, command[1])
    counts = to_counts(min(limit, max(-limit, wanted)), CURRENT_SCALE_A)
    i_d, i_q = park_currents(state, drive)
    row["limited"] = abs(wanted) > limit
    row["current_ref_counts"] = counts
    row["speed_counts"] = to_counts(speed, SPEED_SCALE_RAD_S)
    write_readings(state, plant, row, i_q)
    write_truth(state, plant, row)
    inner_reference = follow_reference(state, plant, counts * CURRENT_SCALE_A)
    # The period that starts now runs with the duties of the tick before.
    if drive["pwm_on"]:
        next_duties = control_currents(state, drive, (i_d, i_q), inner_reference)
        run_period_switching(state, plant, TICK_S)
        renew_slow(state, plant, TICK_S)
        state["duty_a"], state["duty_b"], state["duty_c"] = next_duties
    else:
        release_bridge(state, drive)
        run_period_coasting(state, plant, TICK_S)
        cool_down(state, plant)
    return watch_limits(state, drive, (i_d, i_q), speed)


@njit(cache=True)
def run_ticks(
    state: np.ndarray,
    plant: np.ndarray,
    drive: np.ndarray,
    command: np.ndarray,
    noise: np.ndarray,
    trace: np.ndarray,
) -> tuple[int, int]:
    """Run up to n ticks and stop after one that violates a limit while the bridge is on.

    Args:
        state: Record of `STATE_DTYPE`, shape (1,); advanced in place.
        plant: Record of `PLANT_DTYPE`, shape (1,).
        drive: Record of `DRIVE_DTYPE`, shape (1,).
        command: The program's reference, A, and the weight of the centring loop, 0..1; shape (n, 2).
        noise: Standard normal numbers, shape (n, 3): phase a, phase b, potentiometer.
        trace: Rows to write, shape (n,) of `TRACE_DTYPE`.

    Returns:
        Ticks done, and the bits of the violated limits at the last one.
    """
    memory = state[0]
    machine = plant[0]
    program = drive[0]
    bits = 0
    for index in range(len(command)):
        wanted = command[index, 0], command[index, 1]
        bits = interrupt(memory, machine, program, wanted, noise[index], trace[index])
        memory["tick"] += 1
        if bits != 0 and program["pwm_on"]:
            return index + 1, bits
    return len(command), bits
