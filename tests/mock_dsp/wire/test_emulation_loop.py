"""The loop between program and port: pacing, rates, faults, with a port in memory and a clock by hand."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import pytest

from daq.protocol.codes import DriveState, EventCode
from daq.protocol.commands import Ping, SetBaud, StreamConfig, StreamStart
from daq.protocol.replies import HelloReply, PingReply, StreamStartReply
from mock_dsp.scenario.faults import FaultName
from mock_dsp.scenario.schema import Fault
from mock_dsp.wire.assembly import make_identity
from mock_dsp.wire.emulation import half_frame
from tests.mock_dsp.wire.conftest import HELLO, Rack

if TYPE_CHECKING:
    from collections.abc import Callable


TICK_HZ = 2500
MS = 1_000_000
START_BAUD = 115_200


@pytest.mark.parametrize(("speed", "ticks"), [(1.0, 1000), (10.0, 10_000)])
def test_at_a_factor_the_ticks_follow_the_wall_clock(
    make_rack: Callable[..., Rack], speed: float, ticks: int
) -> None:
    rack = make_rack(speed)
    for _ in range(100):
        rack.spin(1, pass_ns=4 * MS)
        rack.spin(4)
    assert rack.plant.tick == ticks


def test_a_late_wake_up_loses_no_stream_frame(make_rack: Callable[..., Rack]) -> None:
    rack = make_rack(1.0)
    rack.ask(HELLO, pass_ns=4 * MS)
    rack.ask(StreamConfig(layout=1, divisor=2, batch=25), pass_ns=4 * MS)
    rack.ask(StreamStart(), pass_ns=4 * MS)
    streams = rack.spin(1, pass_ns=90 * MS)[0].streams
    for received in rack.spin(12):
        streams += received.streams
    assert rack.line.tx_drops == 0
    assert len(streams) >= 4


def test_a_stream_that_starts_after_an_idle_while_loses_no_frame(make_rack: Callable[..., Rack]) -> None:
    rack = make_rack(1.0)
    rack.ask(HELLO, pass_ns=4 * MS)
    rack.ask(StreamConfig(layout=1, divisor=2, batch=25), pass_ns=4 * MS)
    started = rack.ask(StreamStart(), pass_ns=90 * MS)
    assert isinstance(started, StreamStartReply)
    rack.spin(12)
    assert rack.line.tx_drops == 0


def test_an_idle_controller_keeps_to_the_wall_clock_at_max(make_rack: Callable[..., Rack]) -> None:
    rack = make_rack()
    rack.spin(50)
    assert rack.plant.tick == 0
    rack.spin(50, pass_ns=4 * MS)
    assert rack.plant.tick == 500


def test_a_stream_runs_without_the_wall_clock_at_max(make_rack: Callable[..., Rack]) -> None:
    rack = make_rack()
    rack.ask(HELLO)
    rack.ask(StreamStart())
    before = rack.plant.tick
    rack.spin(40)
    assert rack.plant.tick == before + 40 * 250


def test_time_waits_at_half_a_lease_for_a_live_host(make_rack: Callable[..., Rack]) -> None:
    rack = make_rack()
    rack.stream_armed(lease_ms=2000)
    rack.spin(1000)
    assert rack.plant.tick == 2500
    assert DriveState.SAFE_TIMEOUT not in {event.arg for event in rack.events}


def test_a_dead_host_loses_the_lease_after_its_time_on_the_wall(make_rack: Callable[..., Rack]) -> None:
    rack = make_rack()
    rack.stream_armed(lease_ms=2000)
    rack.spin(100)
    rack.spin(40, pass_ns=100 * MS)
    assert EventCode.LEASE_LOST in {event.code for event in rack.events}


def test_at_max_a_full_port_holds_the_time_and_loses_nothing(make_rack: Callable[..., Rack]) -> None:
    rack = make_rack()
    rack.ask(HELLO)
    rack.ask(StreamStart())
    rack.port.room = 3000
    rack.spin(50)
    held_at = rack.plant.tick
    rack.spin(50)
    assert rack.plant.tick == held_at
    rack.port.room = 1_000_000
    frames = [body for received in rack.spin(20) for body in received.streams]
    assert frames
    assert rack.host.decoder.counters.dropped == 0


def test_beyond_1x_a_full_port_holds_the_time_as_well(make_rack: Callable[..., Rack]) -> None:
    rack = make_rack(20.0)
    rack.ask(HELLO, 4 * MS)
    rack.ask(StreamConfig(layout=1, divisor=2, batch=25), pass_ns=4 * MS)
    rack.ask(StreamStart(), 4 * MS)
    rack.port.room = 3000
    rack.spin(200, pass_ns=4 * MS)
    held_at = rack.plant.tick
    rack.spin(20, pass_ns=4 * MS)
    assert rack.plant.tick == held_at
    rack.port.room = 1_000_000
    assert any(received.streams for received in rack.spin(20, pass_ns=4 * MS))
    assert rack.host.decoder.counters.dropped == 0


def test_at_1x_what_the_host_has_no_room_for_is_lost(make_rack: Callable[..., Rack]) -> None:
    rack = make_rack(1.0)
    rack.port.room = 20
    rack.spin(300, pass_ns=4 * MS)
    assert rack.plant.tick == 3000


def test_a_host_at_another_rate_is_not_understood(make_rack: Callable[..., Rack]) -> None:
    rack = make_rack()
    rack.port.baud = 937_500
    assert rack.ask(HELLO) is None
    assert rack.host.decoder.counters.frames == 0


def test_a_rate_2_percent_away_does_no_harm(make_rack: Callable[..., Rack]) -> None:
    rack = make_rack()
    rack.port.baud = 114_329
    assert isinstance(rack.ask(HELLO), HelloReply)


@pytest.mark.parametrize("speed", [1.0, math.inf])
def test_both_sides_change_the_rate_after_the_reply(make_rack: Callable[..., Rack], speed: float) -> None:
    rack = make_rack(speed)
    rack.ask(HELLO, 4 * MS)
    assert rack.ask(SetBaud(baud=937_500), 4 * MS) is not None
    rack.spin(2, pass_ns=4 * MS)  # whatever was queued behind the reply leaves
    rack.port.baud = 937_500
    assert isinstance(rack.ask(Ping(cookie=3), 4 * MS), PingReply)


def test_during_a_stall_nothing_comes_and_afterwards_everything(make_rack: Callable[..., Rack]) -> None:
    rack = make_rack(1.0, (Fault(name=FaultName.STALL, at_s=0.5, duration_s=1.0),))
    for _ in range(505):
        rack.emulation.begin_due_faults()
        rack.spin(1, pass_ns=4 * MS)
    ticks = [status.tick for status in rack.statuses]
    assert ticks == list(range(250, 5001, 250))


def test_a_pulled_cable_cuts_a_frame_in_half_and_comes_back(make_rack: Callable[..., Rack]) -> None:
    rack = make_rack(1.0, (Fault(name=FaultName.DISCONNECT, at_s=0.15, duration_s=0.4),))
    was_open = []
    for _ in range(250):
        rack.emulation.begin_due_faults()
        rack.spin(1, pass_ns=4 * MS)
        was_open.append(rack.port.is_open)
    closed = was_open.count(False) * 4
    assert 396 <= closed <= 404
    assert was_open[-1]
    # Half a frame before, a whole one after: the two run into each other up to the next delimiter.
    assert rack.host.decoder.counters.dropped == 1


def test_a_restart_has_a_new_session_and_tells_so(make_rack: Callable[..., Rack]) -> None:
    rack = make_rack(1.0, (Fault(name=FaultName.REBOOT, at_s=0.2),))
    rack.ask(HELLO, 4 * MS)
    for _ in range(100):
        rack.emulation.begin_due_faults()
        rack.spin(1, pass_ns=4 * MS)
    boots = {event.arg for event in rack.events if event.code == EventCode.BOOT}
    assert boots == {7, 8}


def test_a_jump_of_the_tick_counter_shows_in_the_status(make_rack: Callable[..., Rack]) -> None:
    rack = make_rack(1.0, (Fault(name=FaultName.TICK_JUMP, at_s=0.3, magnitude=100_000.0),))
    for _ in range(105):
        rack.emulation.begin_due_faults()
        rack.spin(1, pass_ns=4 * MS)
    assert [status.tick for status in rack.statuses] == [250, 500, 750, 101_000]


def test_a_newer_protocol_and_a_wrong_dictionary_show_in_hello() -> None:
    honest = make_identity(1, ())
    assert make_identity(1, {FaultName.NEWER_PROTOCOL}).version == honest.version + 1
    wrong = make_identity(1, {FaultName.WRONG_DICTIONARY})
    assert (wrong.dictionary, wrong.dictionary_crc) == (honest.dictionary, honest.dictionary_crc ^ 1)


@pytest.mark.parametrize(
    ("octets", "kept"),
    [(b"abcdefgh\0", b"abcd"), (b"ab\0cdefgh\0", b"ab\0cde"), (b"abcdef", b"abc"), (b"a\0", b"a")],
)
def test_half_a_frame_ends_between_two_delimiters(octets: bytes, kept: bytes) -> None:
    assert half_frame(octets) == kept
