"""RUN, RUN_ABORT, WAVE_BEGIN, WAVE_DATA, WAVE_COMMIT, SETPOINT_BEGIN, SETPOINT_CHUNK."""

from daq.protocol.codes import ParameterId, SetpointFlag, StatusCode
from daq.protocol.commands import Run, RunAbort, SetpointBegin, SetpointChunk, WaveBegin, WaveCommit, WaveData
from daq.protocol.replies import (
    RunAbortReply,
    RunReply,
    SetpointBeginReply,
    SetpointChunkReply,
    WaveBeginReply,
    WaveCommitReply,
    WaveDataReply,
)
from mock_dsp.program.excitation import Excitation
from mock_dsp.program.handlers.drive import require_phase
from mock_dsp.program.refusal import RefusedError
from mock_dsp.program.setpoints import SetpointPlayer
from mock_dsp.program.state import TICK_HZ, TICK_MASK, ControllerState
from mock_dsp.program.states import Stimulus

_LONGEST_WAIT = 2**31


def run(state: ControllerState, command: Run) -> RunReply:
    """Play a generator."""
    require_phase(state, Stimulus.RUN)
    limit_a = state.parameters.si(ParameterId.CURRENT_LIMIT_A)
    excitation = Excitation(command, state.waves, TICK_HZ, limit_a)
    wait = (command.start_tick - state.tick) & TICK_MASK if command.start_tick else 0
    if command.start_tick and not 1 <= wait < _LONGEST_WAIT:
        raise RefusedError(StatusCode.OUT_OF_RANGE)
    state.drive.run(excitation, state.time + wait, state.time)
    return RunReply(status=StatusCode.OK, start_tick=state.visible_tick(state.time + wait))


def abort_run(state: ControllerState, command: RunAbort) -> RunAbortReply:
    """Ramp what is played to zero; nothing is played, nothing happens."""
    state.drive.stop(state.time)
    return RunAbortReply(status=StatusCode.OK, tick=state.tick)


def begin_wave(state: ControllerState, command: WaveBegin) -> WaveBeginReply:
    """Open a table slot; a table being played was copied when its run began."""
    _accept(state.waves.begin(command.slot, command.length, command.crc))
    return WaveBeginReply(status=StatusCode.OK)


def fill_wave(state: ControllerState, command: WaveData) -> WaveDataReply:
    """Put words into the open slot."""
    _accept(state.waves.fill(command.slot, command.offset, command.words))
    return WaveDataReply(status=StatusCode.OK, slot=command.slot, offset=command.offset)


def commit_wave(state: ControllerState, command: WaveCommit) -> WaveCommitReply:
    """Make a slot playable."""
    _accept(state.waves.commit(command.slot))
    return WaveCommitReply(status=StatusCode.OK)


def begin_setpoints(state: ControllerState, command: SetpointBegin) -> SetpointBeginReply:
    """Open a stream of set-points."""
    require_phase(state, Stimulus.RUN)
    if command.divisor < 1 or command.flags & ~int(SetpointFlag.CENTRING):
        raise RefusedError(StatusCode.OUT_OF_RANGE)
    player = SetpointPlayer(command.divisor, command.flags)
    state.drive.stream_setpoints(player, state.time)
    return SetpointBeginReply(status=StatusCode.OK, free=player.free)


def take_setpoints(state: ControllerState, command: SetpointChunk) -> SetpointChunkReply:
    """Put words behind those that wait."""
    _accept(state.drive.take_setpoints(command.first, command.words))
    player = state.drive.setpoints
    free, played = (player.free, player.played) if player is not None else (0, 0)
    return SetpointChunkReply(status=StatusCode.OK, free=free, played=played & TICK_MASK)


def _accept(status: StatusCode) -> None:
    if status is not StatusCode.OK:
        raise RefusedError(status)
