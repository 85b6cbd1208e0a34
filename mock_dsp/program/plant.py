"""What the program needs of the fast loop and the machine behind it; `mock_dsp.physics.rig` provides it."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from daq.protocol.codes import FaultBit
from mock_dsp.control.parameters import FastLoopParameters


class Trace(Protocol):
    """What a block of ticks brought: one word a tick for each channel, and the trip that ended it, if any."""

    @property
    def ticks_done(self) -> int:
        """Ticks advanced; fewer than asked for after a trip."""

    @property
    def trip(self) -> FaultBit | None:
        """Limit violated at the last tick."""

    @property
    def limited(self) -> NDArray[np.bool_]:
        """Whether the reference was clipped, for each tick."""

    @property
    def current_ref_counts(self) -> NDArray[np.int16]:
        """Reference in force, for each tick."""

    @property
    def current_counts(self) -> NDArray[np.int16]:
        """Measured torque-producing current."""

    @property
    def position_counts(self) -> NDArray[np.uint16]:
        """Potentiometer."""

    @property
    def phase_a_counts(self) -> NDArray[np.int16]:
        """Phase current a."""

    @property
    def phase_b_counts(self) -> NDArray[np.int16]:
        """Phase current b."""

    @property
    def speed_counts(self) -> NDArray[np.int16]:
        """The controller's own speed."""


class Plant(Protocol):
    """The fast loop, advanced in blocks of ticks."""

    @property
    def conditions(self) -> tuple[FaultBit, ...]:
        """Limits violated at the last tick, whether or not the bridge was on."""

    @property
    def bus_voltage_v(self) -> float:
        """Voltage of the DC link."""

    @property
    def temperature_degc(self) -> float:
        """Temperature that the program measures."""

    def set_parameters(self, parameters: FastLoopParameters) -> None:
        """Put settings into force from the next tick on."""

    def run(self, reference_a: NDArray[np.float64], centring_weight: NDArray[np.float64]) -> Trace:
        """Advance one tick for each reference, until a trip; the weight (0 to 1) scales the centring loop."""
