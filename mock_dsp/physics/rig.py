"""The emulated rig: the fast loop with the machine behind it, advanced in blocks of ticks."""

from dataclasses import dataclass, fields
from typing import Self

import numpy as np
from numpy.typing import NDArray

from daq.protocol.codes import FaultBit
from mock_dsp.control.kernels.loop import run_ticks
from mock_dsp.control.layout import TRACE_DTYPE, compile_drive
from mock_dsp.control.parameters import FastLoopParameters
from mock_dsp.physics.noise import NoiseSource
from mock_dsp.physics.plant import SUBSTEPS, compile_plant, initial_state
from mock_dsp.scenario.schema import Scenario

_AMBIENT_DEGC = 25.0
_RISE_AT_RATED_K = 55.0
_COLUMNS = frozenset(TRACE_DTYPE.names or ())


@dataclass(frozen=True, slots=True, kw_only=True)
class RigTrace:
    """What a block of ticks brought, one entry a tick, shape (ticks_done,).

    Entry k belongs to tick `first_tick` + k: the reference commanded there, the rest as sampled at its start.
    The true values are for tests and benchmarks; the controller's program must not use them.

    Attributes:
        first_tick: Tick of entry 0.
        ticks_done: Ticks advanced; fewer than asked for when a limit tripped.
        current_ref_counts: Reference of i_q with centring and limit, 2^-13 A per count.
        current_counts: Measured i_q, 2^-13 A per count.
        position_counts: Potentiometer, 65536 counts over ten turns, 32768 in the middle.
        phase_a_counts: Phase current a, 2^-13 A per count.
        phase_b_counts: Phase current b, 2^-13 A per count.
        speed_counts: The controller's own speed, 2^-7 rad/s per count.
        limited: Whether the reference was clipped to the current limit.
        trip: First limit violated at the last tick, None if none or if the bridge is off.
        true_speed_rad_s: Motor speed.
        true_position_rad: Motor angle.
        true_torque_nm: Torque of the motor.
        true_current_a: Torque-producing current in the true rotor field.
    """

    first_tick: int
    ticks_done: int
    current_ref_counts: NDArray[np.int16]
    current_counts: NDArray[np.int16]
    position_counts: NDArray[np.uint16]
    phase_a_counts: NDArray[np.int16]
    phase_b_counts: NDArray[np.int16]
    speed_counts: NDArray[np.int16]
    limited: NDArray[np.bool_]
    trip: FaultBit | None
    true_speed_rad_s: NDArray[np.float64]
    true_position_rad: NDArray[np.float64]
    true_torque_nm: NDArray[np.float64]
    true_current_a: NDArray[np.float64]


class EmulatedRig:
    """One emulated rig. Running n and then m ticks gives exactly what running n + m ticks gives.

    Attributes:
        parameters: Settings of the fast loop in force.
    """

    def __init__(self, scenario: Scenario, substeps: int = SUBSTEPS) -> None:
        self._scenario = scenario
        self._plant = compile_plant(scenario, substeps)
        self.set_parameters(FastLoopParameters())
        self.reset()

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> Self:
        """Build the rig that a scenario describes, at rest at tick 0."""
        return cls(scenario)

    @property
    def tick(self) -> int:
        """Number of PWM periods since the reset."""
        return int(self._state["tick"][0])

    @property
    def conditions(self) -> tuple[FaultBit, ...]:
        """Limits violated at the last tick, whether or not the bridge was on."""
        return tuple(fault for fault in FaultBit if self._bits >> fault & 1)

    @property
    def bus_voltage_v(self) -> float:
        """Voltage of the DC link, V."""
        return self._scenario.rig.inverter.bus_voltage_v

    @property
    def temperature_degc(self) -> float:
        """Temperature of the motor as its I2t heat model has it, degrees Celsius."""
        return _AMBIENT_DEGC + _RISE_AT_RATED_K * float(self._state["i2t_heat"][0])

    def set_parameters(self, parameters: FastLoopParameters) -> None:
        """Put settings into force from the next tick on."""
        self.parameters = parameters
        self._drive = compile_drive(parameters, self._scenario.rig)
        if self._scenario.rig.sensors.potentiometer_noise_lsb == 0.0:
            # A noise-free potentiometer repeats its reading at rest: the frozen-sensor check would always
            # trip.
            self._drive["sensor_stuck_ticks"] = 0

    def reset(self) -> None:
        """Go back to tick 0, at rest, cold, with the same noise again. Settings stay."""
        self._state = initial_state(self._plant, self._scenario.rig.mechanics.initial_position_rad)
        self._noise = NoiseSource(self._scenario.seed)
        self._bits = 0

    def run(
        self, reference_a: NDArray[np.float64], centring_weight: NDArray[np.float64] | None = None
    ) -> RigTrace:
        """Advance one tick for each reference; stop after a tick that violates a limit with the bridge on.

        Args:
            reference_a: Torque-producing current that the program asks for, shape (n,), A.
            centring_weight: Fade of the centring loop, shape (n,), 0..1; None for 1 throughout.
        """
        weight = np.ones_like(reference_a) if centring_weight is None else centring_weight
        command = np.column_stack((reference_a, weight))
        first_tick = self.tick
        rows = np.empty(len(reference_a), TRACE_DTYPE)
        done = 0
        tripped = False
        while done < len(reference_a) and not tripped:
            noise = self._noise.take(first_tick + done, len(reference_a) - done)
            part = slice(done, done + len(noise))
            advanced, self._bits = run_ticks(
                self._state, self._plant, self._drive, command[part], noise, rows[part]
            )
            done += advanced
            tripped = self.parameters.pwm_on and self._bits != 0
        trip = self.conditions[0] if tripped else None
        return _split_trace(rows[:done], first_tick, trip)


def _split_trace(rows: np.ndarray, first_tick: int, trip: FaultBit | None) -> RigTrace:
    columns = {field.name: rows[field.name] for field in fields(RigTrace) if field.name in _COLUMNS}
    return RigTrace(first_tick=first_tick, ticks_done=len(rows), trip=trip, **columns)
