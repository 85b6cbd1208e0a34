"""What the controller sends unasked: stream frames, STATUS, and the status word they share."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from daq.protocol.codes import StreamStatus
from daq.protocol.framing import encode_frame
from daq.protocol.reports import Status
from mock_dsp.program.capture import CapturePhase
from mock_dsp.program.handlers.link import isr_max_us
from mock_dsp.program.plant import Trace
from mock_dsp.program.setpoints import BUFFER_WORDS
from mock_dsp.program.state import TICK_HZ, ControllerState
from mock_dsp.program.states import LATCHED


def stream_status(state: ControllerState) -> int:
    """Return the status word of a stream frame that is closed now."""
    drive = state.drive
    flags = {
        StreamStatus.FAULT_LATCHED: drive.phase in LATCHED,
        StreamStatus.LIMIT_ACTIVE: drive.limit_active,
        StreamStatus.EXCITATION_ACTIVE: drive.excitation_active(state.time),
        StreamStatus.CAPTURE_READY: state.capture.phase is CapturePhase.READY,
        StreamStatus.TX_OVERRUN: state.line.tx_drops > state.tx_drops_told,
        StreamStatus.TRIP_PENDING: bool(state.plant.conditions) and not drive.faults,
        StreamStatus.LEASE_OK: drive.lease_runs,
    }
    return drive.state | sum(flag for flag, on in flags.items() if on)


def stream_block(state: ControllerState, trace: Trace, status: int) -> None:
    """Queue the stream frames that a block of ticks completes; `state.time` is the block's first tick."""
    queue_stream(state, state.stream.feed(state.time, channel_words(trace), status))


def flush_stream(state: ControllerState) -> None:
    """Queue what waits for its frame as a shorter frame."""
    queue_stream(state, state.stream.flush(stream_status(state)))


def queue_stream(state: ControllerState, bodies: Sequence[bytes]) -> None:
    """Frame stream messages and count them with the link's frames."""
    if not bodies:
        return
    frames = [encode_frame(body) for body in bodies]
    state.tx_drops_told = state.line.tx_drops
    state.link.counters.tx_frames += len(frames)
    state.link.counters.tx_octets += sum(map(len, frames))
    state.queue_droppable(frames)


def channel_words(trace: Trace) -> Mapping[str, NDArray[np.uint16]]:
    """Return a block's words by channel name, each of shape (n,)."""
    return {
        "current_ref": trace.current_ref_counts.view(np.uint16),
        "current": trace.current_counts.view(np.uint16),
        "position": trace.position_counts,
        "phase_a": trace.phase_a_counts.view(np.uint16),
        "phase_b": trace.phase_b_counts.view(np.uint16),
        "speed": trace.speed_counts.view(np.uint16),
    }


def build_status(state: ControllerState) -> Status:
    """Return the STATUS report of this moment."""
    drive, decoder = state.drive, state.link.decoder.counters
    player = drive.setpoints
    return Status(
        state=drive.state,
        faults=drive.faults,
        lease_left_ms=drive.lease_left(state.time) * 1000 // TICK_HZ,
        credits=min(state.link.credits_free, 0xFFFF),
        tick=state.tick,
        rx_errors=decoder.dropped,
        tx_drops=state.line.tx_drops,
        isr_max_us=isr_max_us(state),
        bus_decivolt=round(10.0 * state.plant.bus_voltage_v),
        temperature_decicelsius=round(10.0 * state.plant.temperature_degc),
        setpoints_free=player.free if player is not None else BUFFER_WORDS,
    )
