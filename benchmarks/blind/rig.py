"""Play references on the emulated rig: columns as a driver records them, and the same without sensor noise."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from benchmarks.blind.excitation import TICK_S
from daq.speed.filters import speed_from_position_zero_phase
from mock_dsp.control.parameters import FastLoopParameters
from mock_dsp.physics.rig import EmulatedRig, RigTrace
from mock_dsp.scenario.schema import Scenario

FloatArray = NDArray[np.float64]

FLUX_S = 1.0
"""Time for the rotor flux to build up before a record begins."""
CURRENT_A = 2.0**-13
SPEED_RAD_S = 2.0**-7
TURNS_RAD = 20.0 * np.pi
OBSERVER_HZ = 10.0


class UnusableRunError(Exception):
    """A limit tripped or the reference was clipped: the excitation was too much for what is hidden."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Played:
    """One record.

    Attributes:
        columns: SI columns as recorded, shape (n,) each.
        clean_speed: what `speed_rad_s` would be without sensor noise and quantisation, shape (n,).
        command: total reference, with the centring loop's part, A, shape (n,).
        true_position: motor angle, rad, shape (n,).
    """

    columns: dict[str, FloatArray]
    clean_speed: FloatArray
    command: FloatArray
    true_position: FloatArray


def play(scenario: Scenario, reference: FloatArray, *, tacho: bool = False, centring: bool = True) -> Played:
    """Play a reference on a rig at rest whose rotor flux has built up.

    Args:
        scenario: the rig with all its effects.
        reference: A, shape (n,).
        tacho: `speed_rad_s` is the controller's own speed (layout `speed`), where alone a rectified sensor shows;
            otherwise it is made from the position as the driver makes it.
        centring: add the centring loop's part to the reference.

    Raises:
        UnusableRunError: a limit tripped, or the reference was clipped.
    """
    rig = EmulatedRig.from_scenario(scenario)
    rig.set_parameters(FastLoopParameters(pwm_on=True, centring_on=centring, current_limit_a=2.0))
    rig.run(np.zeros(round(FLUX_S / TICK_S)))
    trace = rig.run(reference)
    if trace.trip is not None or bool(trace.limited.any()):
        raise UnusableRunError(f"{trace.trip or 'reference clipped'} after {trace.ticks_done} ticks")
    position = (trace.position_counts.astype(np.float64) - 32768.0) * TURNS_RAD / 65536.0
    command = trace.current_ref_counts.astype(np.float64) * CURRENT_A
    clean = sensed_position(scenario, trace)
    return Played(
        columns={
            "time_s": np.arange(trace.ticks_done, dtype=np.float64) * TICK_S,
            "current_ref_A": command,
            "current_A": trace.current_counts.astype(np.float64) * CURRENT_A,
            "position_rad": position,
            "speed_rad_s": trace.speed_counts.astype(np.float64) * SPEED_RAD_S
            if tacho
            else speed_from_position_zero_phase(position, TICK_S),
        },
        clean_speed=_own_speed(scenario, clean) if tacho else speed_from_position_zero_phase(clean, TICK_S),
        command=command,
        true_position=trace.true_position_rad,
    )


def sensed_position(scenario: Scenario, trace: RigTrace) -> FloatArray:
    """Return the angle behind potentiometer and wiper filter, before noise and quantisation, shape (n,)."""
    effects = {effect.id: effect.complete_parameters for effect in scenario.effects}
    angle = np.array(trace.true_position_rad, dtype=np.float64)
    bent = effects.get("potentiometer_nonlinearity")
    if bent:
        turn = 2.0 * math.pi * bent["cycles"] / TURNS_RAD
        angle = angle + bent["amplitude_rad"] * np.sin(turn * angle + bent["phase_rad"])
    slow = effects.get("speed_filter_lag")
    if not slow:
        return angle
    gain = -math.expm1(-TICK_S / slow["time_constant_s"])
    # The joint has hardly moved before the record: the filter starts settled.
    return np.asarray(lfilter([gain], [1.0, gain - 1.0], angle - angle[0]) + angle[0])


def _own_speed(scenario: Scenario, clean: FloatArray) -> FloatArray:
    speed = observed_speed(clean)
    rectified = any(effect.id == "rectified_speed_sensor" for effect in scenario.effects)
    return np.abs(speed) if rectified else speed


def observed_speed(angle: FloatArray) -> FloatArray:
    """Return the controller's speed of a noise-free angle: its critically damped observer, shape (n,)."""
    pole = math.exp(-2.0 * math.pi * OBSERVER_HZ * TICK_S)
    gain = (1.0 - pole) ** 2 / TICK_S
    return np.asarray(lfilter([gain, -gain], [1.0, -2.0 * pole, pole * pole], angle - angle[0]))
