"""Both ends of the link joined in memory, on good lines and on bad ones."""

from collections import Counter
from collections.abc import Iterator
from itertools import chain, repeat

import pytest
from hypothesis import given
from hypothesis import strategies as st

from daq.protocol.codes import EventCode, StatusCode
from daq.protocol.commands import Estop, EventAck, Hello, Ping, WaveData
from daq.protocol.device_link import DeviceLink
from daq.protocol.framing import encode_frame
from daq.protocol.host_link import HostLink
from daq.protocol.link_records import LinkTimeout
from daq.protocol.message import Command, Reply
from daq.protocol.messages import encode_message
from daq.protocol.replies import (
    EstopReply,
    EventAckReply,
    HelloReply,
    PingReply,
)
from daq.protocol.reports import Event
from daq.protocol.round_trip import LinkOptions
from daq.protocol.sequence import WINDOW

MS = 1_000_000
HELLO = Hello(proto_min=1, proto_max=1, cookie=0x1234)


def greet(command: Hello, *, session: int = 7, rx_credits: int = 512) -> HelloReply:
    return HelloReply(
        status=StatusCode.OK,
        version=1,
        cookie=command.cookie,
        dictionary_crc=0,
        dictionary_octets=0,
        tick_hz=2500,
        pwm_hz=2500,
        session=session,
        serial_number=1,
        firmware=1,
        rx_credits=rx_credits,
        max_frame=254,
        bauds=(115200,),
    )


class Bench:
    """A host and a controller on one desk; the controller answers HELLO, PING, EVENT_ACK and ESTOP."""

    def __init__(self, options: LinkOptions | None = None) -> None:
        self.host = HostLink(options)
        self.device = DeviceLink()
        self.t_ns = 0
        self.executed: list[Command] = []
        self.replies: list[tuple[int, Reply]] = []
        self.timeouts: list[LinkTimeout] = []
        self.events: list[Event] = []

    def execute(self, data: bytes) -> None:
        """Let the controller receive octets."""
        for seq, command in self.device.receive(data):
            self.executed.append(command)
            match command:
                case Hello():
                    self.device.reply(seq, greet(command))
                case Ping(cookie=cookie):
                    self.device.reply(seq, PingReply(status=0, cookie=cookie, tick=0, subtick=0))
                case EventAck(event=event):
                    self.device.reply(seq, EventAckReply(status=0, event=event))
                case Estop():
                    self.device.reply(seq, EstopReply(status=0))

    def hear(self, data: bytes) -> None:
        """Let the host receive octets."""
        found = self.host.receive(data, self.t_ns)
        self.replies += found.replies
        self.events += found.events

    def settle(self) -> None:
        """Carry octets both ways until nothing moves."""
        while output := self.host.take_output():
            self.execute(output)
            self.hear(self.device.take_output())

    def wait(self) -> None:
        """Let the time pass until the host has something to do."""
        deadline = self.host.next_deadline_ns
        assert deadline is not None
        self.t_ns = deadline
        self.timeouts += self.host.poll(self.t_ns)


@pytest.fixture
def bench() -> Bench:
    bench = Bench()
    bench.host.submit(HELLO, 0)
    bench.settle()
    return bench


def spoil(frame: bytes, fate: str) -> bytes:
    match fate:
        case "lose":
            return b""
        case "twice":
            return frame + frame
        case "corrupt":
            return frame[:2] + bytes([frame[2] ^ 0x10]) + frame[3:]
        case "halve":
            return frame[: len(frame) // 2]
        case _:
            return frame


def frames_of(output: bytes) -> list[bytes]:
    return [part + b"\x00" for part in output.split(b"\x00")[:-1]]


FATES = st.lists(st.sampled_from(["pass", "pass", "lose", "twice", "corrupt", "halve"]), max_size=60)


def run_over_bad_line(bench: Bench, fates: Iterator[str]) -> None:
    while (output := bench.host.take_output()) or bench.host.next_deadline_ns is not None:
        for frame in frames_of(output):
            bench.execute(spoil(frame, next(fates)))
        for frame in frames_of(bench.device.take_output()):
            bench.hear(spoil(frame, next(fates)))
        if not output:
            bench.wait()


@given(fates=FATES, count=st.integers(1, 20), rest=st.sampled_from(["pass", "lose"]))
def test_over_a_bad_line_each_command_is_executed_at_most_once_and_ends(
    fates: list[str], count: int, rest: str
) -> None:
    bench = Bench()
    bench.host.submit(HELLO, 0)
    bench.settle()
    tickets = [bench.host.submit(Ping(cookie=cookie), 0) for cookie in range(count)]
    run_over_bad_line(bench, chain(fates, repeat(rest)))
    executions = Counter(command.cookie for command in bench.executed if isinstance(command, Ping))
    assert max(executions.values(), default=0) <= 1
    replied = {ticket: reply for ticket, reply in bench.replies if ticket in tickets}
    assert sorted([*replied, *(timeout.ticket for timeout in bench.timeouts)]) == tickets
    for ticket, reply in replied.items():
        assert isinstance(reply, PingReply)
        assert tickets[reply.cookie] == ticket


@given(fates=FATES)
def test_over_a_line_that_recovers_the_last_command_is_answered(fates: list[str]) -> None:
    bench = Bench()
    bench.host.submit(HELLO, 0)
    bench.settle()
    bench.host.submit(Ping(cookie=0), 0)
    run_over_bad_line(bench, chain(fates, repeat("pass")))
    last = bench.host.submit(Ping(cookie=99), bench.t_ns)
    run_over_bad_line(bench, repeat("pass"))
    assert last in dict(bench.replies)


@given(st.binary(max_size=800))
def test_no_octets_upset_either_end(noise: bytes) -> None:
    bench = Bench()
    bench.execute(noise)
    bench.hear(noise)
    bench.hear(bench.device.take_output())
    bench.execute(b"\x00")
    bench.hear(b"\x00")
    bench.host.submit(HELLO, 0)
    bench.settle()
    assert any(isinstance(reply, HelloReply) for _, reply in bench.replies)


@given(st.binary(min_size=2, max_size=60).map(lambda half: half + half))
def test_no_message_with_a_good_crc_upsets_either_end(message: bytes) -> None:
    bench = Bench()
    bench.execute(encode_frame(message))
    bench.hear(encode_frame(message))
    host = bench.host.decoder.counters
    assert host.frames == 1


def test_a_lost_reply_is_answered_from_memory(bench: Bench) -> None:
    bench.host.submit(Ping(cookie=5), 0)
    bench.execute(bench.host.take_output())
    bench.device.take_output()  # lost
    bench.wait()
    bench.settle()
    assert bench.executed.count(Ping(cookie=5)) == 1
    assert bench.device.counters.rx_repeated == 1
    assert bench.replies[-1][1] == PingReply(status=0, cookie=5, tick=0, subtick=0)


def test_the_wait_follows_the_round_trip(bench: Bench) -> None:
    for _ in range(60):
        bench.host.submit(Ping(cookie=1), bench.t_ns)
        output = bench.host.take_output()
        bench.t_ns += 100 * MS
        bench.execute(output)
        bench.hear(bench.device.take_output())
    assert bench.host.timer.srtt_ns == pytest.approx(100 * MS, rel=0.01)
    assert bench.host.timer.wait_ns(1) == pytest.approx(100 * MS, rel=0.01)


def test_a_repeated_command_is_not_measured(bench: Bench) -> None:
    bench.host.submit(Ping(cookie=1), 0)
    bench.host.take_output()
    bench.wait()
    bench.t_ns += 400 * MS
    bench.settle()
    assert bench.replies[-1][1] == PingReply(status=0, cookie=1, tick=0, subtick=0)
    assert bench.host.timer.srtt_ns == 0.0  # that of HELLO


def test_a_quick_link_still_waits_25_ms(bench: Bench) -> None:
    assert bench.host.timer.srtt_ns == 0.0
    assert bench.host.timer.wait_ns(1) == 25 * MS


def test_at_most_four_commands_are_under_way(bench: Bench) -> None:
    for cookie in range(7):
        bench.host.submit(Ping(cookie=cookie), 0)
    assert len(frames_of(bench.host.take_output())) == WINDOW


def test_a_lost_command_holds_back_those_four_after_it(bench: Bench) -> None:
    for cookie in range(8):
        bench.host.submit(Ping(cookie=cookie), 0)
    _, *others = frames_of(bench.host.take_output())
    bench.execute(b"".join(others))
    bench.hear(bench.device.take_output())
    assert (
        bench.host.take_output() == b""
    )  # else the lost one's repetition could fall out of the memory of four
    bench.wait()
    bench.settle()
    assert sorted(c.cookie for c in bench.executed if isinstance(c, Ping)) == list(range(8))


def test_octets_under_way_stay_within_the_credits() -> None:
    bench = Bench()
    bench.host.submit(HELLO, 0)
    bench.execute(bench.host.take_output())
    bench.device.take_output()
    bench.hear(encode_frame(encode_message(0, greet(HELLO, rx_credits=300))))
    for offset in range(3):
        bench.host.submit(WaveData(slot=0, offset=offset, words=bytes(192)), 0)
    assert len(frames_of(bench.host.take_output())) == 1
    assert bench.host.octets_under_way <= 300


def test_estop_is_repeated_until_answered(bench: Bench) -> None:
    ticket = bench.host.submit(Estop(), 0)
    bench.host.take_output()
    bench.wait()
    bench.settle()
    assert ticket in dict(bench.replies)


def test_an_event_is_delivered_once_and_acknowledged(bench: Bench) -> None:
    event = Event(event=3, code=EventCode.STATE, tick=9, arg=1)
    for _ in range(3):
        bench.device.send(event)
    bench.hear(bench.device.take_output())
    bench.settle()
    assert bench.events == [event]
    assert bench.executed.count(EventAck(event=3)) == 1
    assert bench.host.counters.repeated_events == 2
    assert len(bench.replies) == 1  # that to HELLO: the link keeps replies to its own commands for itself


def test_events_of_a_restarted_controller_are_new_although_their_numbers_are_not(bench: Bench) -> None:
    first = Event(event=1, code=EventCode.BOOT, tick=0, arg=7)
    again = Event(event=1, code=EventCode.BOOT, tick=0, arg=8)
    bench.device.send(first)
    bench.hear(bench.device.take_output())
    bench.settle()
    bench.device = DeviceLink()
    bench.device.send(again)
    bench.hear(bench.device.take_output())
    assert bench.events == [first, again]
    assert bench.host.take_output() == b""  # no acknowledgement before the new HELLO
