"""PARAM_GET, PARAM_SET, PARAM_SAVE."""

from daq.protocol.codes import ParameterId, StatusCode
from daq.protocol.commands import ParamGet, ParamSave, ParamSet
from daq.protocol.replies import ParamGetReply, ParamSaveReply, ParamSetReply
from mock_dsp.program.refusal import RefusedError
from mock_dsp.program.state import ControllerState


def get_parameter(state: ControllerState, command: ParamGet) -> ParamGetReply:
    """Read a parameter, measured ones fresh."""
    state.parameters.measure(ParameterId.BUS_VOLTAGE_V, state.plant.bus_voltage_v)
    state.parameters.measure(ParameterId.TEMPERATURE_DEGC, state.plant.temperature_degc)
    status, raw = state.parameters.get(command.parameter)
    if status is not StatusCode.OK:
        raise RefusedError(status)
    return ParamGetReply(status=status, parameter=command.parameter, raw=raw)


def set_parameter(state: ControllerState, command: ParamSet) -> ParamSetReply:
    """Write a parameter, clamped, into force from the next tick on."""
    status, raw = state.parameters.set(command.parameter, command.raw, armed=state.drive.powered)
    if status not in (StatusCode.OK, StatusCode.CLAMPED):
        raise RefusedError(status)
    state.drive.apply_parameters()
    return ParamSetReply(status=status, parameter=command.parameter, raw=raw)


def save_parameters(state: ControllerState, command: ParamSave) -> ParamSaveReply:
    """Keep the parameters over a restart; erasing the flash would stop the fast loop, so not while armed."""
    if state.drive.powered:
        raise RefusedError(StatusCode.WRONG_STATE)
    state.flash.update(state.parameters.snapshot())
    return ParamSaveReply(status=StatusCode.OK)
