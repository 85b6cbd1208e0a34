"""STREAM_CONFIG, STREAM_START, STREAM_STOP."""

from daq.protocol.codes import StatusCode
from daq.protocol.commands import StreamConfig, StreamStart, StreamStop
from daq.protocol.replies import StreamConfigReply, StreamStartReply, StreamStopReply
from mock_dsp.program.refusal import RefusedError
from mock_dsp.program.reports import flush_stream
from mock_dsp.program.state import ControllerState
from mock_dsp.program.stream import StreamSettings, check_settings


def configure_stream(state: ControllerState, command: StreamConfig) -> StreamConfigReply:
    """Choose what the next stream carries."""
    if state.stream.running:
        raise RefusedError(StatusCode.WRONG_STATE)
    settings = check_settings(command.layout, command.divisor, command.batch)
    if not isinstance(settings, StreamSettings):
        raise RefusedError(settings)
    state.stream.settings = settings
    return StreamConfigReply(
        status=StatusCode.OK, layout=settings.layout.id, divisor=settings.divisor, batch=settings.batch
    )


def start_stream(state: ControllerState, command: StreamStart) -> StreamStartReply:
    """Start with the next tick's sample."""
    if state.stream.running:
        raise RefusedError(StatusCode.WRONG_STATE)
    state.stream.start(state.time)
    return StreamStartReply(status=StatusCode.OK, tick=state.tick)


def stop_stream(state: ControllerState, command: StreamStop) -> StreamStopReply:
    """Send what waits, and stop; a stream that does not run is stopped already."""
    end = state.visible_tick(state.stream.next_sample(state.time))
    flush_stream(state)
    state.stream.stop()
    return StreamStopReply(status=StatusCode.OK, tick=end)
