"""The literal table from command to what executes it."""

from collections.abc import Callable
from types import MappingProxyType
from typing import Any

from daq.protocol import commands as wire
from daq.protocol.message import Command, Reply
from daq.protocol.replies import Refusal
from mock_dsp.program.handlers import capture, drive, excitation, link, parameters, stream
from mock_dsp.program.refusal import RefusedError
from mock_dsp.program.state import ControllerState

# Any: each handler takes its own command class, which the key states.
Handler = Callable[[ControllerState, Any], Reply]

HANDLERS: MappingProxyType[type[Command], Handler] = MappingProxyType(
    {
        wire.Hello: link.hello,
        wire.DictRead: link.read_dictionary,
        wire.Ping: link.ping,
        wire.LinkStats: link.report_link,
        wire.SetBaud: link.set_baud,
        wire.EventAck: link.acknowledge_event,
        wire.ParamGet: parameters.get_parameter,
        wire.ParamSet: parameters.set_parameter,
        wire.ParamSave: parameters.save_parameters,
        wire.StreamConfig: stream.configure_stream,
        wire.StreamStart: stream.start_stream,
        wire.StreamStop: stream.stop_stream,
        wire.Arm: drive.arm,
        wire.KeepAlive: drive.keep_alive,
        wire.Disarm: drive.disarm,
        wire.Estop: drive.stop_at_once,
        wire.ClearFault: drive.clear_fault,
        wire.Run: excitation.run,
        wire.RunAbort: excitation.abort_run,
        wire.WaveBegin: excitation.begin_wave,
        wire.WaveData: excitation.fill_wave,
        wire.WaveCommit: excitation.commit_wave,
        wire.SetpointBegin: excitation.begin_setpoints,
        wire.SetpointChunk: excitation.take_setpoints,
        wire.CaptureConfig: capture.configure_capture,
        wire.CaptureArm: capture.arm_capture,
        wire.CaptureRead: capture.read_capture,
    }
)


def execute(state: ControllerState, command: Command) -> Reply:
    """Execute a command and return its reply, in the short form if it is refused."""
    try:
        return HANDLERS[type(command)](state, command)
    except RefusedError as refusal:
        return Refusal(command=command.TYPE, status=refusal.status)
