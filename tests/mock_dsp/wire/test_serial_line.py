"""The transmit ring with its FIFO, and the receive buffer, paced in ticks."""

import pytest

from mock_dsp.program.line_counters import LineCounters
from mock_dsp.program.state import OutFrame
from mock_dsp.wire.lines import (
    FIFO_OCTETS,
    RECEIVE_OCTETS,
    REPLY_OCTETS,
    RING_OCTETS,
    OctetClock,
    ReceiveLine,
    TransmitLine,
)

TICK_HZ = 2500
BAUD = 250_000  # ten octets a tick
CAPACITY = RING_OCTETS + FIFO_OCTETS


@pytest.fixture
def counters() -> LineCounters:
    return LineCounters()


@pytest.fixture
def transmit(counters: LineCounters) -> TransmitLine:
    return TransmitLine(counters, OctetClock(TICK_HZ), CAPACITY, BAUD)


@pytest.fixture
def receive(counters: LineCounters) -> ReceiveLine:
    return ReceiveLine(counters, OctetClock(TICK_HZ))


def stream(size: int, value: int = 1) -> OutFrame:
    return OutFrame(bytes([value]) * size, droppable=True)


def reply(size: int, value: int = 2) -> OutFrame:
    return OutFrame(bytes([value]) * size, droppable=False)


def test_octets_leave_at_the_modelled_rate(transmit: TransmitLine) -> None:
    transmit.offer([stream(100)])
    assert [len(transmit.elapse(ticks)) for ticks in (1, 3, 5, 5)] == [10, 30, 50, 10]


def test_parts_of_an_octet_are_carried_over(counters: LineCounters) -> None:
    line = TransmitLine(counters, OctetClock(TICK_HZ), CAPACITY, 115_200)
    line.offer([stream(500)])
    assert sum(len(line.elapse(1)) for _ in range(100)) == 460  # 115200 / 10 / 2500 * 100 = 460.8


def test_an_idle_line_saves_up_no_time(transmit: TransmitLine) -> None:
    transmit.elapse(1000)
    transmit.offer([stream(100)])
    assert len(transmit.elapse(1)) == 10


def test_a_full_ring_drops_whole_stream_frames_and_counts_them(
    transmit: TransmitLine, counters: LineCounters
) -> None:
    transmit.offer([stream(200, value) for value in range(1, 5)])
    assert transmit.elapse(1000) == bytes([1]) * 200 + bytes([2]) * 200
    assert (counters.tx_drops, counters.tx_dropped_octets) == (2, 400)


def test_replies_wait_for_room_and_stream_frames_give_way(
    transmit: TransmitLine, counters: LineCounters
) -> None:
    transmit.offer([stream(500), reply(200), stream(20, 3)])
    assert transmit.elapse(1000) == bytes([1]) * 500 + bytes([2]) * 200
    assert counters.tx_drops == 1


def test_the_reply_buffer_gives_up_its_oldest_when_nothing_leaves(
    transmit: TransmitLine, counters: LineCounters
) -> None:
    transmit.offer([reply(256) for _ in range(10)])
    assert transmit.backlog <= CAPACITY + REPLY_OCTETS
    assert counters.tx_drops == 4


def test_the_rate_changes_when_what_was_queued_has_left(transmit: TransmitLine) -> None:
    transmit.offer([reply(25)])
    transmit.follow_baud(2 * BAUD)
    transmit.offer([stream(100, 3)])
    assert transmit.elapse(2) == bytes([2]) * 20
    assert transmit.baud == BAUD
    assert transmit.elapse(2) == bytes([2]) * 5
    assert transmit.baud == 2 * BAUD
    assert len(transmit.elapse(2)) == 40


def test_the_rate_of_an_empty_line_changes_at_once(transmit: TransmitLine) -> None:
    transmit.follow_baud(2 * BAUD)
    assert transmit.baud == 2 * BAUD


def test_a_line_without_pacing_passes_everything_at_once(counters: LineCounters) -> None:
    line = TransmitLine(counters, None, 65_536, BAUD)
    line.offer([stream(30_000), reply(200)])
    assert len(line.elapse(0)) == 30_200


def test_received_octets_arrive_at_the_modelled_rate(receive: ReceiveLine) -> None:
    receive.send(bytes(25))
    assert [len(receive.elapse(1, BAUD)) for _ in range(4)] == [10, 10, 5, 0]
    assert not receive.arriving


def test_what_comes_faster_than_it_is_taken_is_lost_and_counted(
    receive: ReceiveLine, counters: LineCounters
) -> None:
    receive.send(bytes(1000))
    room = RECEIVE_OCTETS + FIFO_OCTETS
    assert len(receive.elapse(100, BAUD)) == room
    assert counters.rx_overruns == 1000 - room
