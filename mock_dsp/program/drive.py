"""The drive: its phase, lease, faults, ramps, and which reference is played.

All times here are ticks since boot (`time`), which never jump; what the host sees as the tick counter is made
of them where messages are built.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from daq.protocol.codes import CURRENT_COUNT_A, DriveState, EventCode, FaultBit, ParameterId, StatusCode
from mock_dsp.control.parameters import TICK_S
from mock_dsp.program.excitation import Excitation
from mock_dsp.program.parameters import ParameterStore
from mock_dsp.program.plant import Plant, Trace
from mock_dsp.program.setpoints import SetpointPlayer
from mock_dsp.program.states import DRIVE_STATES, LATCHED, POWERED, RAMPS, Phase, Stimulus, follow


@dataclass(frozen=True, slots=True, kw_only=True)
class Happening:
    """Something to be told to the host as an event."""

    code: EventCode
    arg: int = 0


class Drive:
    """The drive's state and what moves it.

    Attributes:
        phase: where it is in the table of `states.py`.
        faults: latched faults, one bit each.
        excitation: what RUN plays, None without.
        setpoints: what the host streams, None without.
        lease_ticks: length of the lease.
        limit_active: whether the reference was clipped at the last tick.
        was_powered: whether the bridge was ever on since boot.

    Args:
        plant: fast loop and machine.
        parameters: limits and times in force.
    """

    def __init__(self, plant: Plant, parameters: ParameterStore) -> None:
        self._plant = plant
        self._parameters = parameters
        self.phase = Phase.IDLE
        self.faults = 0
        self.excitation: Excitation | None = None
        self.setpoints: SetpointPlayer | None = None
        self.lease_ticks = 0
        self._lease_end = 0
        self._start = 0
        self._ramp_end = 0
        self._ramp_ticks = 1
        self._ramp_from_a = 0.0
        self._reference_a = 0.0
        self._limit_told = False
        self.limit_active = False
        self.was_powered = False
        self._underrun = False
        self._happenings: list[Happening] = []
        self.apply_parameters()

    @property
    def state(self) -> DriveState:
        """State as the wire knows it."""
        return DRIVE_STATES[self.phase]

    @property
    def powered(self) -> bool:
        """Whether the bridge is switching."""
        return self.phase in POWERED

    @property
    def estop_latched(self) -> bool:
        """Whether the latched fault is an emergency stop."""
        return bool(self.faults >> FaultBit.ESTOP & 1)

    @property
    def moving(self) -> bool:
        """Whether a reference is played or ramped."""
        return self.phase is Phase.RUNNING or self.phase in RAMPS

    @property
    def lease_runs(self) -> bool:
        """Whether a keep-alive is owed."""
        return self.powered and self.phase is not Phase.RAMPING_TO_SAFE

    def lease_left(self, time: int) -> int:
        """Return the ticks until the lease expires; 0 without one."""
        return max(0, self._lease_end - time) if self.lease_runs else 0

    def excitation_active(self, time: int) -> bool:
        """Return whether a reference is being played."""
        if self.phase is not Phase.RUNNING:
            return False
        return self.setpoints.playing if self.setpoints is not None else time >= self._start

    def take_happenings(self) -> list[Happening]:
        """Return what happened since the last call."""
        happenings, self._happenings = self._happenings, []
        return happenings

    def arm(self, time: int, lease_ticks: int) -> None:
        """Switch the bridge on under a lease."""
        self.lease_ticks = lease_ticks
        self.renew_lease(time)
        self._move(Stimulus.ARM, time)

    def renew_lease(self, time: int) -> None:
        """Start the lease anew."""
        self._lease_end = time + self.lease_ticks

    def run(self, excitation: Excitation, start: int, time: int) -> None:
        """Play an excitation from `start` on."""
        self.excitation, self.setpoints, self._start = excitation, None, start
        self._limit_told = False
        self._move(Stimulus.RUN, time)
        if start == time:
            self._tell(EventCode.RUN_STARTED)

    def stream_setpoints(self, player: SetpointPlayer, time: int) -> None:
        """Play set-points as soon as the first half is there."""
        self.excitation, self.setpoints = None, player
        self._limit_told = False
        self._move(Stimulus.RUN, time)

    def take_setpoints(self, first: int, octets: bytes) -> StatusCode:
        """Put words behind those that wait in the running stream of set-points."""
        if self.setpoints is None:
            return StatusCode.UNDERRUN if self._underrun else StatusCode.WRONG_STATE
        before = self.setpoints.playing
        status = self.setpoints.append(first, octets, self._parameters.si(ParameterId.CURRENT_LIMIT_A))
        if self.setpoints.playing and not before:
            self._tell(EventCode.RUN_STARTED)
        return status

    def stop(self, time: int) -> None:
        """Ramp the excitation to zero and stay armed."""
        self._move(Stimulus.STOP, time)

    def disarm(self, time: int) -> None:
        """Ramp to zero, then switch off."""
        self._move(Stimulus.DISARM, time)

    def emergency_stop(self, time: int) -> None:
        """Switch off at once and latch."""
        if not self.estop_latched:
            self.faults |= 1 << FaultBit.ESTOP
            self._tell(EventCode.ESTOP)
        self._move(Stimulus.ESTOP, time)

    def trip(self, fault: FaultBit, time: int) -> None:
        """Switch off at once and latch a fault."""
        self.faults |= 1 << fault
        self._tell(EventCode.FAULT, fault)
        self._move(Stimulus.TRIP, time)

    def clear(self, time: int) -> int:
        """Leave a latched state if its cause is gone; return the faults that are still present."""
        present = sum(1 << condition for condition in self._plant.conditions)
        self.faults &= present
        if not self.faults:
            self._move(Stimulus.CLEAR, time)
        return self.faults

    def horizon(self, time: int) -> int:
        """Return the ticks until the drive does something by itself, at least 1."""
        ends = []
        if self.lease_runs:
            ends.append(self._lease_end - time)
        if self.phase in RAMPS:
            ends.append(self._ramp_end - time)
        if self.phase is Phase.RUNNING:
            ends.append(self._run_horizon(time))
        return max(1, min(ends, default=1 << 30))

    def advance(self, time: int, ticks: int) -> Trace:
        """Run the fast loop for `ticks`, not more than the horizon, and do what is due at its end."""
        reference, weight = self._reference(time, ticks)
        trace = self._plant.run(reference, weight)
        self._reference_a = float(trace.current_ref_counts[-1]) * CURRENT_COUNT_A
        self._watch_limit(trace)
        end = time + trace.ticks_done
        if trace.trip is not None:
            self.trip(trace.trip, end)
        self._finish_block(end)
        return trace

    def apply_parameters(self) -> None:
        """Give the fast loop the parameters in force."""
        source = self.excitation or self.setpoints
        centring = self.phase is Phase.RUNNING and source is not None and source.centring
        self._plant.set_parameters(self._parameters.fast_loop(pwm_on=self.powered, centring_on=centring))

    def _run_horizon(self, time: int) -> int:
        if self.setpoints is not None:
            return self.setpoints.ticks_left if self.setpoints.playing else 1 << 30
        if time < self._start:
            return self._start - time
        length = self.excitation.length_ticks if self.excitation is not None else None
        return self._start + length - time if length is not None else 1 << 30

    def _reference(self, time: int, ticks: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return reference in A and centring weight for the next ticks, each of shape (ticks,)."""
        nothing = np.zeros(ticks)
        if self.phase in RAMPS:
            left = self._ramp_end - time - 1 - np.arange(ticks)
            return self._ramp_from_a * (left / self._ramp_ticks), nothing
        if not self.excitation_active(time):
            return nothing, nothing
        if self.setpoints is not None:
            return self.setpoints.play(ticks), np.ones(ticks)
        if self.excitation is None:
            return nothing, nothing
        first = time - self._start
        return self.excitation.reference(first, ticks), self.excitation.fade(first, ticks)

    def _finish_block(self, time: int) -> None:
        if self.lease_runs and time >= self._lease_end:
            self._tell(EventCode.LEASE_LOST)
            self._move(Stimulus.LEASE_LOST, time)
        elif self.phase in RAMPS and time >= self._ramp_end:
            self._move(Stimulus.RAMP_DONE, time)
        elif self.phase is Phase.RUNNING:
            self._watch_end(time)

    def _watch_end(self, time: int) -> None:
        if self.setpoints is not None:
            if self.setpoints.playing and not self.setpoints.ticks_left:
                self._underrun = True
                self._tell(EventCode.UNDERRUN)
                self._move(Stimulus.STOP, time)
            return
        length = self.excitation.length_ticks if self.excitation is not None else None
        if time == self._start:
            self._tell(EventCode.RUN_STARTED)
        if length is not None and time >= self._start + length:
            self._move(Stimulus.STOP, time)

    def _watch_limit(self, trace: Trace) -> None:
        self.limit_active = bool(trace.limited[-1])
        if not self._limit_told and self.powered and bool(np.any(trace.limited)):
            self._limit_told = True
            self._tell(EventCode.LIMIT)

    def _move(self, stimulus: Stimulus, time: int) -> None:
        """Follow the table, start or end what belongs to the new phase, and tell the host."""
        before, self.phase = self.phase, follow(self.phase, stimulus)
        if self.phase is before:
            return
        if self.phase in RAMPS and before not in RAMPS:
            self._ramp_ticks = max(1, math.floor(self._parameters.si(ParameterId.RAMP_TIME_S) / TICK_S + 0.5))
            self._ramp_from_a = self._reference_a
            self._ramp_end = time + self._ramp_ticks
        if self.phase in LATCHED or self.phase is Phase.IDLE:
            self._reference_a = 0.0
        self.was_powered |= self.powered
        if self.phase is Phase.RUNNING:
            self._underrun = False
        if before is Phase.RUNNING:
            self.excitation = self.setpoints = None
            self._tell(EventCode.RUN_DONE)
        if DRIVE_STATES[before] is not self.state:
            self._tell(EventCode.STATE, self.state)
        self.apply_parameters()

    def _tell(self, code: EventCode, arg: int = 0) -> None:
        self._happenings.append(Happening(code=code, arg=arg))
