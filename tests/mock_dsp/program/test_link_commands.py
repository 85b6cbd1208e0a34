"""HELLO, dictionary, parameters, time, link counters, baud rate, events and STATUS."""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING

import pytest

from daq.protocol.codes import LIMIT_PARAMETERS, EventCode, ParameterId, StatusCode
from daq.protocol.commands import (
    DictRead,
    Estop,
    Hello,
    LinkStats,
    ParamGet,
    ParamSave,
    ParamSet,
    Ping,
    SetBaud,
)
from daq.protocol.dictionary import parse_dictionary
from daq.protocol.replies import (
    DictReadReply,
    HelloReply,
    LinkStatsReply,
    ParamGetReply,
    ParamSetReply,
    PingReply,
)
from mock_dsp.program.dictionary import DICTIONARY
from mock_dsp.program.parameters import ParameterStore

if TYPE_CHECKING:
    from tests.mock_dsp.conftest import Bench

CURRENT_LIMIT = ParameterId.CURRENT_LIMIT_A
REPEAT_TICKS = 250


def read_dictionary(bench: Bench) -> bytes:
    octets = b""
    total = 1
    while len(octets) < total:
        reply = bench.ask(DictRead(offset=len(octets), count=192))
        assert isinstance(reply, DictReadReply)
        octets += reply.data
        total = reply.total
    return octets


def test_hello_without_a_common_version_is_refused_with_the_one_spoken(bench: Bench) -> None:
    reply = bench.ask(Hello(proto_min=2, proto_max=9, cookie=5))
    assert isinstance(reply, HelloReply)
    assert (reply.status, reply.version) == (StatusCode.UNSUPPORTED_VERSION, 1)


def test_the_dictionary_read_in_pieces_is_the_announced_one(bench: Bench) -> None:
    hello = bench.greet()
    octets = read_dictionary(bench)
    assert (len(octets), zlib.crc32(octets)) == (hello.dictionary_octets, hello.dictionary_crc)
    assert parse_dictionary(octets) == DICTIONARY


@pytest.mark.parametrize(("offset", "count"), [(0, 194), (0, 3), (100_000, 2)])
def test_a_wrong_piece_of_the_dictionary_is_refused(bench: Bench, offset: int, count: int) -> None:
    bench.greet()
    assert bench.status_of(DictRead(offset=offset, count=count)) == StatusCode.OUT_OF_RANGE


def test_the_limits_crc_covers_the_raw_limits_in_the_documented_order(bench: Bench) -> None:
    bench.greet()
    raws = []
    for parameter in LIMIT_PARAMETERS:
        reply = bench.ask(ParamGet(parameter=parameter))
        assert isinstance(reply, ParamGetReply)
        raws.append(reply.raw)
    assert zlib.crc32(struct.pack("<6i", *raws)) == ParameterStore({}).limits_crc()


@pytest.mark.parametrize(
    ("asked", "in_force", "status"),
    [(1500, 1500, StatusCode.OK), (5000, 2000, StatusCode.CLAMPED), (-1, 0, StatusCode.CLAMPED)],
)
def test_a_parameter_is_clamped_to_its_range(
    bench: Bench, asked: int, in_force: int, status: StatusCode
) -> None:
    bench.greet()
    reply = bench.ask(ParamSet(parameter=CURRENT_LIMIT, raw=asked))
    assert isinstance(reply, ParamSetReply)
    assert (reply.raw, reply.status) == (in_force, status)
    assert bench.plant.parameters.current_limit_a == pytest.approx(in_force * 1e-3)


def test_a_measured_parameter_shows_what_is_measured_and_cannot_be_written(bench: Bench) -> None:
    bench.greet()
    reply = bench.ask(ParamGet(parameter=ParameterId.TEMPERATURE_DEGC))
    assert isinstance(reply, ParamGetReply)
    assert reply.raw == 315
    assert bench.status_of(ParamSet(parameter=ParameterId.TEMPERATURE_DEGC, raw=1)) == StatusCode.NOT_WRITABLE


def test_an_unknown_parameter_is_refused(bench: Bench) -> None:
    bench.greet()
    assert bench.status_of(ParamGet(parameter=99)) == StatusCode.UNKNOWN_PARAMETER
    assert bench.status_of(ParamSet(parameter=99, raw=0)) == StatusCode.UNKNOWN_PARAMETER


def test_a_limit_is_locked_while_armed_and_the_centring_gain_is_not(armed: Bench) -> None:
    assert armed.status_of(ParamSet(parameter=CURRENT_LIMIT, raw=1000)) == StatusCode.NOT_WRITABLE
    assert armed.status_of(ParamSet(parameter=ParameterId.CENTRING_GAIN_A_RAD, raw=5000)) == StatusCode.OK
    assert armed.plant.parameters.centring_gain_a_rad == pytest.approx(0.005)


def test_saved_parameters_survive_a_restart_and_others_do_not(bench: Bench) -> None:
    bench.greet()
    bench.ask(ParamSet(parameter=CURRENT_LIMIT, raw=1200))
    bench.ask(ParamSave())
    bench.ask(ParamSet(parameter=CURRENT_LIMIT, raw=900))
    bench.boot(8)
    bench.greet()
    reply = bench.ask(ParamGet(parameter=CURRENT_LIMIT))
    assert isinstance(reply, ParamGetReply)
    assert reply.raw == 1200


def test_a_restart_has_another_session_and_starts_at_tick_0(bench: Bench) -> None:
    bench.greet()
    bench.run_ticks(1000)
    bench.boot(8)
    assert bench.greet().session == 8
    reply = bench.ask(Ping(cookie=1))
    assert isinstance(reply, PingReply)
    assert reply.tick == 0


def test_a_ping_tells_the_visible_tick_after_a_jump(bench: Bench) -> None:
    bench.greet()
    bench.run_ticks(100)
    bench.controller.jump_ticks(1_000_000)
    reply = bench.ask(Ping(cookie=77))
    assert isinstance(reply, PingReply)
    assert (reply.cookie, reply.tick) == (77, 1_000_100)


def test_link_counters_tell_frames_damage_and_drops(bench: Bench) -> None:
    bench.greet()
    bench.controller.receive(b"\x05abcd\x00")
    bench.line.tx_drops, bench.line.tx_dropped_octets, bench.line.rx_overruns = 2, 60, 9
    before = bench.ask(LinkStats())
    after = bench.ask(LinkStats())
    assert isinstance(before, LinkStatsReply) and isinstance(after, LinkStatsReply)
    assert (before.rx_malformed, before.tx_drops, before.rx_overruns) == (1, 2, 9)
    assert after.rx_frames == before.rx_frames + 1
    assert (after.tx_frames - before.tx_frames, after.tx_octets - before.tx_octets) == (1, 44)


def test_a_rate_that_is_not_announced_is_refused(bench: Bench) -> None:
    bench.greet()
    assert bench.status_of(SetBaud(baud=921_600)) == StatusCode.OUT_OF_RANGE


def test_a_ping_makes_the_new_rate_stay(bench: Bench) -> None:
    bench.greet()
    bench.ask(SetBaud(baud=937_500))
    bench.run_ticks(1249)
    bench.ask(Ping(cookie=0))
    bench.run_ticks(2500)
    assert bench.controller.baud == 937_500


def test_without_a_ping_the_rate_reverts_after_500_ms(bench: Bench) -> None:
    bench.greet()
    bench.ask(SetBaud(baud=937_500))
    bench.run_ticks(1249)
    assert bench.controller.baud == 937_500
    bench.run_ticks(1)
    assert bench.controller.baud == 115_200
    reverted = [event.arg for event in bench.events if event.code == EventCode.BAUD_REVERTED]
    assert reverted == [115_200]


def test_an_unproven_rate_is_a_duty_of_the_host(bench: Bench) -> None:
    bench.greet()
    bench.ask(SetBaud(baud=937_500))
    bench.run_ticks(250)
    assert [(duty.left_ticks, duty.full_ticks) for duty in bench.controller.duties()] == [(1000, 1250)]


def test_an_event_is_repeated_every_100_ms_until_acknowledged(bench: Bench) -> None:
    bench.run_ticks(0)
    bench.run_ticks(4 * REPEAT_TICKS)  # no session yet: the host cannot acknowledge BOOT
    assert bench.host.counters.repeated_events == 4
    bench.greet()
    bench.run_ticks(REPEAT_TICKS)
    bench.run_ticks(1)
    repeated = bench.host.counters.repeated_events
    bench.run_ticks(4 * REPEAT_TICKS)
    assert bench.host.counters.repeated_events == repeated
    assert [(event.code, event.arg) for event in bench.events] == [(EventCode.BOOT, 7)]


def test_only_the_newest_events_are_kept_for_a_host_that_acknowledges_nothing(bench: Bench) -> None:
    for _ in range(20):
        bench.controller.jump_ticks(1)
        bench.status_of(Estop())
    bench.run_ticks(REPEAT_TICKS)
    assert len({event.event for event in bench.events}) == 3  # BOOT, ESTOP, STATE: once stopped, no more


def test_status_comes_ten_times_a_second_and_tells_the_state(armed: Bench) -> None:
    for _ in range(20):
        armed.run_ticks(125)
    assert [status.tick for status in armed.statuses] == list(range(250, 2501, 250))
    first = armed.statuses[0]
    assert (first.state, first.lease_left_ms, first.faults) == (1, 1900, 0)
    assert (first.bus_decivolt, first.temperature_decicelsius, first.setpoints_free) == (5400, 315, 512)
