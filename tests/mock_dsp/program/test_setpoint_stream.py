"""Streamed set-points: two halves, order, room, underrun."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from daq.protocol.codes import CURRENT_COUNT_A, DriveState, EventCode, StatusCode
from daq.protocol.commands import RunAbort, SetpointBegin, SetpointChunk
from daq.protocol.replies import SetpointBeginReply, SetpointChunkReply

if TYPE_CHECKING:
    from tests.mock_dsp.conftest import Bench

HALF = 256
CHUNK = 64


def begin(bench: Bench, divisor: int = 1, flags: int = 0) -> None:
    reply = bench.ask(SetpointBegin(divisor=divisor, flags=flags))
    assert isinstance(reply, SetpointBeginReply) and reply.free == 2 * HALF


def chunk(first: int, count: int = CHUNK) -> SetpointChunk:
    """Return words that hold their own number."""
    return SetpointChunk(first=first, words=np.arange(first, first + count, dtype="<i2").tobytes())


def send(bench: Bench, first: int, end: int) -> SetpointChunkReply:
    """Send whole chunks up to word `end`; return the last reply."""
    replies = [bench.ask(chunk(start)) for start in range(first, end, CHUNK)]
    last = replies[-1]
    assert isinstance(last, SetpointChunkReply)
    return last


@pytest.mark.parametrize("divisor", [1, 3])
def test_words_are_played_in_order_once_the_first_half_is_full(armed: Bench, divisor: int) -> None:
    begin(armed, divisor)
    send(armed, 0, HALF - CHUNK)
    armed.run_ticks(50)
    assert np.all(armed.plant.played() == 0.0)
    send(armed, HALF - CHUNK, HALF)
    armed.run_ticks(HALF)
    played = np.round(armed.plant.played()[50:] / CURRENT_COUNT_A)
    np.testing.assert_array_equal(played, np.arange(HALF) // divisor)
    started = next(event for event in armed.events if event.code == EventCode.RUN_STARTED)
    assert started.tick == 50


def test_a_half_becomes_free_as_a_whole(armed: Bench) -> None:
    begin(armed)
    assert send(armed, 0, 2 * HALF).free == 0
    armed.run_ticks(HALF - 1)
    assert armed.status_of(chunk(2 * HALF)) == StatusCode.NO_CREDIT
    armed.run_ticks(1)
    reply = armed.ask(chunk(2 * HALF))
    assert isinstance(reply, SetpointChunkReply)
    assert (reply.free, reply.played) == (HALF - CHUNK, HALF)


def test_a_chunk_out_of_order_is_refused_and_nothing_taken(armed: Bench) -> None:
    begin(armed)
    send(armed, 0, CHUNK)
    assert armed.status_of(chunk(0)) == StatusCode.OUT_OF_RANGE
    assert armed.status_of(chunk(2 * CHUNK)) == StatusCode.OUT_OF_RANGE
    assert armed.status_of(chunk(CHUNK)) == StatusCode.OK


@pytest.mark.parametrize("word", [16385, -16385, -32768])
def test_a_word_beyond_the_current_limit_is_refused(armed: Bench, word: int) -> None:
    begin(armed)
    octets = np.array([0, word], dtype="<i2").tobytes()
    assert armed.status_of(SetpointChunk(first=0, words=octets)) == StatusCode.OUT_OF_RANGE


@pytest.mark.parametrize(("divisor", "flags"), [(0, 0), (1, 2)])
def test_an_impossible_stream_of_setpoints_is_refused(armed: Bench, divisor: int, flags: int) -> None:
    assert armed.status_of(SetpointBegin(divisor=divisor, flags=flags)) == StatusCode.OUT_OF_RANGE


def test_chunks_without_a_stream_are_refused(armed: Bench) -> None:
    assert armed.status_of(chunk(0)) == StatusCode.WRONG_STATE


def test_an_underrun_ramps_to_zero_and_is_told(armed: Bench) -> None:
    begin(armed)
    send(armed, 0, HALF)
    armed.run_ticks(HALF)
    assert armed.drive_state() is DriveState.RAMPING
    armed.run_ticks(125)
    assert armed.drive_state() is DriveState.ARMED
    assert EventCode.UNDERRUN in armed.event_codes()
    ramp = armed.plant.played()[HALF:]
    assert ramp[-1] == 0.0 and np.all(np.diff(ramp) < 0.0)
    assert armed.status_of(chunk(HALF)) == StatusCode.UNDERRUN


def test_after_an_underrun_the_stream_can_begin_anew(armed: Bench) -> None:
    begin(armed)
    send(armed, 0, HALF)
    for _ in range(2):
        armed.run_ticks(200)
    begin(armed)
    assert armed.status_of(chunk(0)) == StatusCode.OK


def test_a_stream_of_setpoints_ends_in_order_by_an_abort(armed: Bench) -> None:
    begin(armed)
    send(armed, 0, 2 * HALF)
    armed.run_ticks(100)
    armed.ask(RunAbort())
    armed.run_ticks(125)
    assert armed.drive_state() is DriveState.ARMED
    assert EventCode.UNDERRUN not in armed.event_codes()


def test_the_next_words_are_a_duty_of_the_host(armed: Bench) -> None:
    begin(armed, divisor=2)
    send(armed, 0, 2 * HALF)
    armed.run_ticks(24)
    duties = {duty.full_ticks: duty.left_ticks for duty in armed.controller.duties()}
    assert duties[2 * HALF] == 4 * HALF - 24


def test_the_centring_loop_acts_while_words_are_played(armed: Bench) -> None:
    begin(armed, flags=1)
    armed.run_ticks(10)
    send(armed, 0, HALF)
    armed.run_ticks(10)
    weight = np.concatenate(armed.plant.weight)
    assert list(weight) == [0.0] * 10 + [1.0] * 10
