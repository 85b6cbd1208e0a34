"""The sample stream: ticks, batches, layouts, status word, order on the wire."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from daq.protocol.codes import DriveState, StatusCode, StreamStatus
from daq.protocol.commands import StreamConfig, StreamStart, StreamStop
from daq.protocol.dictionary_entries import Layout
from daq.protocol.messages import decode_message
from daq.protocol.replies import StreamStartReply, StreamStopReply
from daq.protocol.reports import Stream
from mock_dsp.program.dictionary import LAYOUTS
from mock_dsp.program.stream import StreamEncoder, StreamSettings

if TYPE_CHECKING:
    from tests.mock_dsp.conftest import Bench, RunMaker

POSITION = 2  # word of the channel in which the fake plant counts ticks


def sample_ticks(frames: list[Stream], channels: int) -> list[int]:
    """Return the ticks that the samples themselves hold."""
    words = np.frombuffer(b"".join(frame.samples for frame in frames), dtype="<u2")
    return list(map(int, words.reshape(-1, channels)[:, POSITION]))


@pytest.mark.parametrize("entry", LAYOUTS, ids=lambda layout: str(layout.name))
@pytest.mark.parametrize(("divisor", "batch"), [(1, 1), (1, 24), (3, 10), (7, 24)])
def test_every_sample_is_sent_once_at_its_tick(bench: Bench, entry: Layout, divisor: int, batch: int) -> None:
    bench.greet()
    bench.run_ticks(11)
    bench.ask(StreamConfig(layout=entry.id, divisor=divisor, batch=batch))
    started = bench.ask(StreamStart())
    for ticks in (1, 2, 250, 97, 13):
        bench.run_ticks(ticks)
    stopped = bench.ask(StreamStop())
    assert isinstance(started, StreamStartReply) and isinstance(stopped, StreamStopReply)
    expected = list(range(started.tick, 374, divisor))
    assert sample_ticks(bench.frames, len(entry.channels)) == expected
    assert [frame.tick0 for frame in bench.frames] == expected[::batch]
    assert stopped.tick == expected[-1] + divisor


@pytest.mark.parametrize(
    ("layout", "divisor", "batch"),
    [(0, 1, 1), (4, 1, 1), (1, 0, 1), (1, 1, 0), (1, 1, 41), (2, 1, 25), (3, 1, 31)],
)
def test_an_impossible_stream_is_refused(bench: Bench, layout: int, divisor: int, batch: int) -> None:
    bench.greet()
    command = StreamConfig(layout=layout, divisor=divisor, batch=batch)
    assert bench.status_of(command) == StatusCode.OUT_OF_RANGE


def test_a_running_stream_is_not_started_or_configured_again(bench: Bench) -> None:
    bench.greet()
    bench.ask(StreamStart())
    assert bench.status_of(StreamStart()) == StatusCode.WRONG_STATE
    assert bench.status_of(StreamConfig(layout=1, divisor=1, batch=1)) == StatusCode.WRONG_STATE


def test_a_stream_that_does_not_run_can_be_stopped(bench: Bench) -> None:
    bench.greet()
    assert bench.status_of(StreamStop()) == StatusCode.OK


def test_the_last_frame_goes_out_before_the_reply_to_stop(bench: Bench) -> None:
    bench.greet()
    bench.ask(StreamStart())
    bench.run_ticks(7)
    bench.host.submit(StreamStop(), 0)
    bench.controller.receive(bench.host.take_output())
    bench.controller.serve(1000)
    last, reply = bench.controller.take_frames()[-2:]
    assert (last.droppable, reply.droppable) == (True, False)


def test_the_numbers_of_the_frames_start_at_0_with_each_stream_and_wrap(bench: Bench) -> None:
    bench.greet()
    bench.ask(StreamConfig(layout=1, divisor=1, batch=1))
    bench.ask(StreamStart())
    bench.run_ticks(10)
    bench.ask(StreamStop())
    bench.ask(StreamStart())
    bench.controller.advance(300)
    frames = [frame.octets for frame in bench.controller.take_frames() if frame.droppable]
    bodies = bench.host.decoder.feed(b"".join(frames))
    assert [body[1] for body in bodies] == [number & 0xFF for number in range(300)]


def test_the_status_word_follows_the_drive(armed: Bench, make_run: RunMaker) -> None:
    armed.ask(StreamStart())
    armed.run_ticks(25)
    armed.ask(make_run())
    armed.run_ticks(25)
    armed.plant.trip_tick = 60
    armed.run_ticks(100)
    words = [frame.status for frame in armed.frames]
    assert words[0] == DriveState.ARMED | StreamStatus.LEASE_OK
    assert words[1] == DriveState.RUNNING | StreamStatus.LEASE_OK | StreamStatus.EXCITATION_ACTIVE
    assert words[-1] == DriveState.FAULT | StreamStatus.FAULT_LATCHED


def test_a_dropped_frame_is_told_in_the_next_one_only(bench: Bench) -> None:
    bench.greet()
    bench.ask(StreamStart())
    bench.line.tx_drops = 3
    bench.run_ticks(25)
    bench.run_ticks(25)
    flags = [bool(frame.status & StreamStatus.TX_OVERRUN) for frame in bench.frames]
    assert flags == [True, False]


def test_a_jump_of_the_counter_falls_between_two_frames(bench: Bench) -> None:
    bench.greet()
    bench.ask(StreamStart())
    bench.run_ticks(30)
    bench.controller.jump_ticks(5000)
    bench.run_ticks(30)
    assert [(frame.tick0, frame.batch) for frame in bench.frames] == [(0, 25), (25, 5), (5030, 25)]


def test_the_tick_wraps_at_32_bit() -> None:
    encoder = StreamEncoder()
    encoder.settings = StreamSettings(batch=2)
    encoder.tick_offset = 2**32 - 2
    encoder.start(0)
    words = {name: np.zeros(4, dtype=np.uint16) for name in encoder.settings.layout.channels}
    frames = [decode_message(body)[1] for body in encoder.feed(0, words, 0)]
    assert [frame.tick0 for frame in frames if isinstance(frame, Stream)] == [2**32 - 2, 0]
