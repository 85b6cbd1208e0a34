"""The drive's state machine as one literal table.

The wire knows six states (`DriveState`). The program needs to remember in addition where a ramp to zero
ends, so it works on eight phases; RAMPING is three of them. A pair that is not in the table leaves the
phase as it is: whether a command in that phase is refused is decided by `refuse`.
"""

from enum import Enum, auto

from daq.protocol.codes import DriveState, StatusCode


class Phase(Enum):
    """What the drive is doing, the end of a ramp included."""

    IDLE = auto()
    ARMED = auto()
    RUNNING = auto()
    RAMPING_TO_ARMED = auto()
    RAMPING_TO_IDLE = auto()
    RAMPING_TO_SAFE = auto()
    SAFE_TIMEOUT = auto()
    FAULT = auto()


class Stimulus(Enum):
    """What can move the drive from one phase to another."""

    ARM = auto()
    DISARM = auto()
    RUN = auto()
    STOP = auto()  # RUN_ABORT, the excitation's own end, or a set-point underrun
    RAMP_DONE = auto()
    LEASE_LOST = auto()
    ESTOP = auto()
    TRIP = auto()
    CLEAR = auto()


TRANSITIONS: dict[tuple[Phase, Stimulus], Phase] = {
    (Phase.IDLE, Stimulus.ARM): Phase.ARMED,
    (Phase.IDLE, Stimulus.ESTOP): Phase.FAULT,
    (Phase.IDLE, Stimulus.TRIP): Phase.FAULT,
    (Phase.ARMED, Stimulus.RUN): Phase.RUNNING,
    (Phase.ARMED, Stimulus.DISARM): Phase.IDLE,
    (Phase.ARMED, Stimulus.LEASE_LOST): Phase.SAFE_TIMEOUT,
    (Phase.ARMED, Stimulus.ESTOP): Phase.FAULT,
    (Phase.ARMED, Stimulus.TRIP): Phase.FAULT,
    (Phase.RUNNING, Stimulus.STOP): Phase.RAMPING_TO_ARMED,
    (Phase.RUNNING, Stimulus.DISARM): Phase.RAMPING_TO_IDLE,
    (Phase.RUNNING, Stimulus.LEASE_LOST): Phase.RAMPING_TO_SAFE,
    (Phase.RUNNING, Stimulus.ESTOP): Phase.FAULT,
    (Phase.RUNNING, Stimulus.TRIP): Phase.FAULT,
    (Phase.RAMPING_TO_ARMED, Stimulus.RAMP_DONE): Phase.ARMED,
    (Phase.RAMPING_TO_ARMED, Stimulus.DISARM): Phase.RAMPING_TO_IDLE,
    (Phase.RAMPING_TO_ARMED, Stimulus.LEASE_LOST): Phase.RAMPING_TO_SAFE,
    (Phase.RAMPING_TO_ARMED, Stimulus.ESTOP): Phase.FAULT,
    (Phase.RAMPING_TO_ARMED, Stimulus.TRIP): Phase.FAULT,
    (Phase.RAMPING_TO_IDLE, Stimulus.RAMP_DONE): Phase.IDLE,
    (Phase.RAMPING_TO_IDLE, Stimulus.LEASE_LOST): Phase.RAMPING_TO_SAFE,
    (Phase.RAMPING_TO_IDLE, Stimulus.ESTOP): Phase.FAULT,
    (Phase.RAMPING_TO_IDLE, Stimulus.TRIP): Phase.FAULT,
    (Phase.RAMPING_TO_SAFE, Stimulus.RAMP_DONE): Phase.SAFE_TIMEOUT,
    (Phase.RAMPING_TO_SAFE, Stimulus.ESTOP): Phase.FAULT,
    (Phase.RAMPING_TO_SAFE, Stimulus.TRIP): Phase.FAULT,
    (Phase.SAFE_TIMEOUT, Stimulus.CLEAR): Phase.IDLE,
    (Phase.SAFE_TIMEOUT, Stimulus.ESTOP): Phase.FAULT,
    (Phase.SAFE_TIMEOUT, Stimulus.TRIP): Phase.FAULT,
    (Phase.FAULT, Stimulus.CLEAR): Phase.IDLE,
}

RAMPS = frozenset({Phase.RAMPING_TO_ARMED, Phase.RAMPING_TO_IDLE, Phase.RAMPING_TO_SAFE})
LATCHED = frozenset({Phase.SAFE_TIMEOUT, Phase.FAULT})
POWERED = frozenset({Phase.ARMED, Phase.RUNNING}) | RAMPS

DRIVE_STATES: dict[Phase, DriveState] = {
    Phase.IDLE: DriveState.IDLE,
    Phase.ARMED: DriveState.ARMED,
    Phase.RUNNING: DriveState.RUNNING,
    Phase.RAMPING_TO_ARMED: DriveState.RAMPING,
    Phase.RAMPING_TO_IDLE: DriveState.RAMPING,
    Phase.RAMPING_TO_SAFE: DriveState.RAMPING,
    Phase.SAFE_TIMEOUT: DriveState.SAFE_TIMEOUT,
    Phase.FAULT: DriveState.FAULT,
}


def follow(phase: Phase, stimulus: Stimulus) -> Phase:
    """Return the phase after `stimulus`: the table's, or the same one where the table has none."""
    return TRANSITIONS.get((phase, stimulus), phase)


def refuse(phase: Phase, stimulus: Stimulus, *, estop: bool) -> StatusCode:
    """Return why a command may not act as `stimulus` in `phase`, or OK.

    Args:
        phase: where the drive is.
        stimulus: what the command would cause.
        estop: the latched fault is an emergency stop.
    """
    if (phase, stimulus) in TRANSITIONS:
        return StatusCode.OK
    if phase in LATCHED:
        return StatusCode.ESTOP_LATCHED if estop else StatusCode.FAULT_LATCHED
    return StatusCode.WRONG_STATE
