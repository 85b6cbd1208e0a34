"""ARM, KEEP_ALIVE, DISARM, ESTOP, CLEAR_FAULT."""

from daq.protocol.codes import ParameterId, StatusCode
from daq.protocol.commands import Arm, ClearFault, Disarm, Estop, KeepAlive
from daq.protocol.replies import ArmReply, ClearFaultReply, DisarmReply, EstopReply, KeepAliveReply
from mock_dsp.program.parameter_table import LEASE_MS
from mock_dsp.program.refusal import RefusedError
from mock_dsp.program.state import TICK_HZ, ControllerState
from mock_dsp.program.states import Stimulus, refuse


def arm(state: ControllerState, command: Arm) -> ArmReply:
    """Switch the drive on, for a host that knows this session and the limits in force."""
    require_phase(state, Stimulus.ARM)
    if command.session != state.identity.session:
        raise RefusedError(StatusCode.WRONG_SESSION)
    if command.limits_crc != state.parameters.limits_crc():
        raise RefusedError(StatusCode.WRONG_LIMITS)
    asked_ms = command.lease_ms or round(1e3 * state.parameters.si(ParameterId.LEASE_DEFAULT_S))
    lease_ms = min(max(asked_ms, LEASE_MS.start), LEASE_MS.stop - 1)
    state.drive.arm(state.time, lease_ms * TICK_HZ // 1000)
    return ArmReply(status=StatusCode.OK if lease_ms == asked_ms else StatusCode.CLAMPED, lease_ms=lease_ms)


def keep_alive(state: ControllerState, command: KeepAlive) -> KeepAliveReply:
    """Renew the lease of a drive that is on."""
    if command.session != state.identity.session:
        raise RefusedError(StatusCode.WRONG_SESSION)
    if not state.drive.lease_runs:
        latched = refuse(state.drive.phase, Stimulus.ARM, estop=state.drive.estop_latched)
        raise RefusedError(StatusCode.WRONG_STATE if latched is StatusCode.OK else latched)
    left_ms = lease_left_ms(state)
    state.drive.renew_lease(state.time)
    return KeepAliveReply(status=StatusCode.OK, lease_left_ms=left_ms)


def disarm(state: ControllerState, command: Disarm) -> DisarmReply:
    """Ramp to zero and switch off; a drive that is off stays off."""
    state.drive.disarm(state.time)
    return DisarmReply(status=StatusCode.OK)


def stop_at_once(state: ControllerState, command: Estop) -> EstopReply:
    """Switch off at once and latch, in every state and for every session."""
    state.drive.emergency_stop(state.time)
    return EstopReply(status=StatusCode.OK)


def clear_fault(state: ControllerState, command: ClearFault) -> ClearFaultReply:
    """Leave a latched state; faults whose cause is still there stay latched."""
    present = state.drive.clear(state.time)
    return ClearFaultReply(status=StatusCode.FAULT_LATCHED if present else StatusCode.OK, faults=present)


def require_phase(state: ControllerState, stimulus: Stimulus) -> None:
    """Refuse a command that the drive's phase does not allow.

    Raises:
        RefusedError: with the reason.
    """
    status = refuse(state.drive.phase, stimulus, estop=state.drive.estop_latched)
    if status is not StatusCode.OK:
        raise RefusedError(status)


def lease_left_ms(state: ControllerState) -> int:
    """Return what is left of the lease, rounded down."""
    return state.drive.lease_left(state.time) * 1000 // TICK_HZ
