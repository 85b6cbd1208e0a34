"""Indirect field-oriented current control, one call a tick.

The field angle is pole pairs times the measured shaft angle plus the integral of the slip that the nominal
rotor resistance asks for (Novotny and Lipo, ch. 5). Currents sampled at tick k give the duties of period k
+ 1: one tick of computation, as on the real controller; the voltage vector is turned ahead by one and a
half periods.
"""

import math

import numpy as np
from numba import njit

from mock_dsp.control.parameters import CURRENT_SCALE_A, POSITION_COUNTS, TICK_S
from mock_dsp.physics.kernels.inverter import current_sign

_SQRT3 = math.sqrt(3.0)
_TURN = 2.0 * math.pi
_ANGLE_SCALE = 20.0 * math.pi / POSITION_COUNTS
_MIN_FLUX_SHARE = 0.1


@njit(cache=True)
def measured_angle(state: np.void) -> float:
    """Return the shaft angle that the potentiometer shows, rad."""
    counts: float = state["position_counts"] - POSITION_COUNTS // 2
    return _ANGLE_SCALE * counts


@njit(cache=True)
def observe_shaft(state: np.void, drive: np.void) -> None:
    """Advance the critically damped tracking observer of angle and speed (10 Hz)."""
    predicted = state["observed_angle"] + TICK_S * state["observed_speed"]
    error = measured_angle(state) - predicted
    state["observed_angle"] = predicted + drive["observer_angle"] * error
    state["observed_speed"] += drive["observer_speed"] * error


@njit(cache=True)
def park_currents(state: np.void, drive: np.void) -> tuple[float, float]:
    """Return the measured (i_d, i_q), A, in the controller's field coordinates."""
    alpha = CURRENT_SCALE_A * state["phase_a_counts"]
    beta = (alpha + 2.0 * CURRENT_SCALE_A * state["phase_b_counts"]) / _SQRT3
    angle = drive["pole_pairs"] * state["observed_angle"] + state["slip_angle"]
    cosine, sine = math.cos(angle), math.sin(angle)
    return cosine * alpha + sine * beta, cosine * beta - sine * alpha


@njit(cache=True)
def advance_slip(state: np.void, drive: np.void, reference_q: float) -> float:
    """Advance flux model and slip angle by one tick; return the speed of the field, rad/s electrical."""
    full = drive["mutual_inductance"] * drive["flux_current"]
    state["flux_estimate"] += TICK_S * drive["rotor_decay"] * (full - state["flux_estimate"])
    slip = drive["slip_gain"] * reference_q / max(state["flux_estimate"], _MIN_FLUX_SHARE * full)
    angle = state["slip_angle"] + TICK_S * slip
    state["slip_angle"] = angle - _TURN * math.floor(angle / _TURN)
    field_speed: float = drive["pole_pairs"] * state["observed_speed"] + slip
    return field_speed


@njit(cache=True)
def control_currents(
    state: np.void, drive: np.void, measured: tuple[float, float], reference_q: float
) -> tuple[float, float, float]:
    """Return the duties of the next period from measured (i_d, i_q) and the reference of i_q, A."""
    angle = drive["pole_pairs"] * state["observed_angle"] + state["slip_angle"]
    field_speed = advance_slip(state, drive, reference_q)
    error_d = drive["flux_current"] - measured[0]
    error_q = reference_q - measured[1]
    leakage, flux = drive["leakage"], state["flux_estimate"]
    feed_d = -field_speed * leakage * reference_q - drive["coupling"] * flux
    # The rotor resistance is in the controllers' pole: what is left to feed is the shaft's induced voltage.
    shaft_speed = drive["pole_pairs"] * state["observed_speed"]
    feed_q = field_speed * leakage * drive["flux_current"] + shaft_speed * drive["emf_gain"] * flux
    gain = drive["proportional"]
    wanted_d = gain * error_d + state["integral_d"] + feed_d
    wanted_q = gain * error_q + state["integral_q"] + feed_q
    limit = drive["bus_voltage"] / _SQRT3
    size = math.sqrt(wanted_d * wanted_d + wanted_q * wanted_q)
    scale = min(1.0, limit / max(size, 1e-9))
    # Back-calculation: what the bridge could not give is taken out of the integrators' input.
    state["integral_d"] += drive["integral"] * TICK_S * (error_d - (1.0 - scale) * wanted_d / gain)
    state["integral_q"] += drive["integral"] * TICK_S * (error_q - (1.0 - scale) * wanted_q / gain)
    ahead = angle + 1.5 * TICK_S * field_speed
    return modulate(state, drive, (scale * wanted_d, scale * wanted_q), ahead)


@njit(cache=True)
def modulate(
    state: np.void, drive: np.void, voltage: tuple[float, float], angle: float
) -> tuple[float, float, float]:
    """Return the duties of the three legs for a voltage (d, q), V, at a field angle.

    Adding half of the largest and smallest phase voltage to all three centres the pulses, which is
    space-vector modulation and reaches bus/sqrt(3) (Holmes and Lipo, Pulse Width Modulation, ch. 6).
    """
    cosine, sine = math.cos(angle), math.sin(angle)
    alpha = cosine * voltage[0] - sine * voltage[1]
    beta = sine * voltage[0] + cosine * voltage[1]
    a = alpha
    b = -0.5 * alpha + 0.5 * _SQRT3 * beta
    c = -0.5 * alpha - 0.5 * _SQRT3 * beta
    centre = 0.5 - 0.5 * (max(a, b, c) + min(a, b, c)) / drive["bus_voltage"]
    current_a = CURRENT_SCALE_A * state["phase_a_counts"]
    current_b = CURRENT_SCALE_A * state["phase_b_counts"]
    return (
        compensated_duty(drive, centre, a, current_a),
        compensated_duty(drive, centre, b, current_b),
        compensated_duty(drive, centre, c, -current_a - current_b),
    )


@njit(cache=True)
def compensated_duty(drive: np.void, centre: float, voltage: float, current: float) -> float:
    """Return the duty of one leg, 0..1, lengthened by what the known dead time takes from it."""
    duty: float = centre + voltage / drive["bus_voltage"] + drive["dead_time"] * current_sign(current)
    return min(1.0, max(0.0, duty))


@njit(cache=True)
def release_bridge(state: np.void, drive: np.void) -> None:
    """Forget the controllers' memory while the bridge is off; the flux estimate decays with the rotor."""
    state["integral_d"] = 0.0
    state["integral_q"] = 0.0
    state["flux_estimate"] -= TICK_S * drive["rotor_decay"] * state["flux_estimate"]
    state["duty_a"] = 0.5
    state["duty_b"] = 0.5
    state["duty_c"] = 0.5
