"""The host's end of the link alone: tries, e-stop, replies that are not ours."""

from dataclasses import fields

import pytest

from daq.protocol.commands import Estop, Hello, Ping, WaveData
from daq.protocol.framing import encode_frame
from daq.protocol.host_link import ESTOP_COPIES, HostLink
from daq.protocol.link_records import LinkTimeout
from daq.protocol.message import Message
from daq.protocol.messages import encode_message
from daq.protocol.replies import EstopReply, HelloReply, PingReply
from daq.protocol.round_trip import LinkOptions

MS = 1_000_000
HELLO = Hello(proto_min=1, proto_max=1, cookie=0x1234)


def frame(seq: int, message: Message) -> bytes:
    return encode_frame(encode_message(seq, message))


def wait_it_out(host: HostLink) -> tuple[list[int], list[LinkTimeout]]:
    """Let the time pass without any reply; return when something was due, in ms, and what was given up."""
    times, given_up = [], []
    while (deadline_ns := host.next_deadline_ns) is not None:
        times.append(deadline_ns // MS)
        given_up += host.poll(deadline_ns)
    return times, given_up


def test_a_silent_line_gives_up_after_three_tries() -> None:
    host = HostLink()
    ticket = host.submit(HELLO, 0)
    times, given_up = wait_it_out(host)
    assert given_up == [LinkTimeout(ticket=ticket, command=HELLO, tries=3)]
    assert host.take_output() == frame(0, HELLO) * 3
    assert times == [250, 750, 1750]
    assert (host.counters.retries, host.counters.timeouts) == (2, 1)


def test_the_wait_doubles_with_each_try_up_to_the_maximum() -> None:
    host = HostLink(LinkOptions(tries=5, rto_initial_ns=200 * MS))
    host.submit(HELLO, 0)
    assert wait_it_out(host)[0] == [200, 600, 1400, 2400, 3400]


def test_sequence_numbers_wrap() -> None:
    host = HostLink(LinkOptions(first_seq=255))
    for cookie in range(2):
        host.submit(Ping(cookie=cookie), 0)
    assert host.take_output() == frame(255, Ping(cookie=0)) + frame(0, Ping(cookie=1))


def test_estop_goes_out_at_once_three_times_past_a_full_window() -> None:
    host = HostLink()
    for cookie in range(9):
        host.submit(Ping(cookie=cookie), 0)
    host.take_output()
    ticket = host.submit(Estop(), 0)
    assert host.take_output() == encode_frame(b"\x1b\x00") * ESTOP_COPIES
    found = host.receive(frame(0, EstopReply(status=0)), 0)
    assert found.replies == [(ticket, EstopReply(status=0))]


def test_replies_nobody_waits_for_are_counted() -> None:
    host = HostLink()
    host.submit(Ping(cookie=1), 0)
    found = host.receive(frame(200, PingReply(status=0, cookie=1, tick=1, subtick=0)), 0)
    found_estop = host.receive(frame(0, EstopReply(status=0)), 0)
    assert found.replies == found_estop.replies == []
    assert host.counters.late_replies == 2


def test_a_hello_reply_with_another_cookie_is_not_ours() -> None:
    host = HostLink()
    host.submit(HELLO, 0)
    numbers = {field.name: 0 for field in fields(HelloReply) if field.name not in ("cookie", "bauds")}
    assert host.receive(frame(0, HelloReply(cookie=5, bauds=(), **numbers)), 0).replies == []
    assert host.receive(frame(0, HelloReply(cookie=0x1234, bauds=(), **numbers)), 0).replies != []


def test_a_message_too_long_for_a_frame_is_refused_on_submission() -> None:
    with pytest.raises(ValueError, match="exceeds 250"):
        HostLink().submit(WaveData(slot=0, offset=0, words=bytes(400)), 0)
