"""CAPTURE_CONFIG, CAPTURE_ARM, CAPTURE_READ."""

from daq.protocol.codes import StatusCode
from daq.protocol.commands import CaptureArm, CaptureConfig, CaptureRead
from daq.protocol.message import MAX_DATA_OCTETS
from daq.protocol.replies import CaptureArmReply, CaptureConfigReply, CaptureReadReply
from mock_dsp.program.capture import CapturePhase, CaptureSettings, check_capture
from mock_dsp.program.refusal import RefusedError
from mock_dsp.program.state import ControllerState


def configure_capture(state: ControllerState, command: CaptureConfig) -> CaptureConfigReply:
    """Set up the buffer; what it held is gone."""
    settings = check_capture(command)
    if not isinstance(settings, CaptureSettings):
        raise RefusedError(settings)
    state.capture.configure(settings)
    return CaptureConfigReply(status=StatusCode.OK, depth=settings.depth)


def arm_capture(state: ControllerState, command: CaptureArm) -> CaptureArmReply:
    """Start to fill the buffer anew."""
    if state.capture.settings is None:
        raise RefusedError(StatusCode.NO_DATA)
    state.capture.arm(state.time)
    return CaptureArmReply(status=StatusCode.OK)


def read_capture(state: ControllerState, command: CaptureRead) -> CaptureReadReply:
    """Serve words of a finished capture; a total of 0 says that there is none yet."""
    if 2 * command.count > MAX_DATA_OCTETS:
        raise RefusedError(StatusCode.OUT_OF_RANGE)
    total, words = state.capture.read(command.offset, command.count)
    if state.capture.phase is CapturePhase.READY and command.offset > total:
        raise RefusedError(StatusCode.OUT_OF_RANGE)
    return CaptureReadReply(
        status=StatusCode.OK,
        offset=command.offset,
        total=total,
        trigger_tick=state.visible_tick(state.capture.trigger_time) if total else 0,
        words=words,
    )
