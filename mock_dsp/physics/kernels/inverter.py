"""Two-level bridge with centre-aligned pulses and dead time, averaged exactly over each sub-step.

During the dead time both switches of a leg are open and the diode that carries the current decides: an
outgoing current delays the rising edge, an incoming one the falling edge. Near zero current the parasitic
capacitances of the switches decide; a linear transition of +-20 mA stands for them. With the bridge off,
the diodes drive the current to zero; a resistor limited to half the bus voltage stands for that.
"""

import math

import numpy as np
from numba import njit

_TRANSITION_A = 0.02
_DIODE_OHM = 2000.0
_SQRT3 = math.sqrt(3.0)


@njit(cache=True)
def current_sign(current_a: float) -> float:
    """Return the direction of a phase current with the transition near zero, -1..1."""
    return min(1.0, max(-1.0, current_a / _TRANSITION_A))


@njit(cache=True)
def pulse_edges(duty: float, sign: float, dead_time: float) -> tuple[float, float]:
    """Return rising and falling edge of one leg as fractions of the period.

    Args:
        duty: Commanded on-time, fraction of the period.
        sign: Direction of the phase current, see `current_sign`.
        dead_time: Fraction of the period.
    """
    rise = 0.5 * (1.0 - duty) + 0.5 * dead_time * (1.0 + sign)
    fall = 0.5 * (1.0 + duty) + 0.5 * dead_time * (1.0 - sign)
    return rise, fall


@njit(cache=True)
def on_share(edges: tuple[float, float], start: float, stop: float) -> float:
    """Return which share of the interval start..stop (fractions of the period) a leg is on."""
    overlap = min(edges[1], stop) - max(edges[0], start)
    return max(0.0, overlap) / (stop - start)


@njit(cache=True)
def bridge_voltage(plant: np.void, a: float, b: float, c: float) -> tuple[float, float]:
    """Return the stator voltage (alpha, beta), V, for the on-shares of the three legs."""
    bus = plant["bus_voltage"]
    return bus * (2.0 * a - b - c) / 3.0, bus * (b - c) / _SQRT3


@njit(cache=True)
def diode_voltage(plant: np.void, current: tuple[float, float]) -> tuple[float, float]:
    """Return the stator voltage (alpha, beta), V, with all switches open."""
    limit = 0.5 * plant["bus_voltage"]
    return (
        min(limit, max(-limit, -_DIODE_OHM * current[0])),
        min(limit, max(-limit, -_DIODE_OHM * current[1])),
    )
