"""The controller's end of the link alone: sessions, refusals, credits, numbers of reports."""

from dataclasses import fields

import pytest

from daq.protocol.codes import StatusCode
from daq.protocol.commands import Estop, Hello, LinkStats, Ping, StreamStart, WaveData
from daq.protocol.device_link import DeviceLink
from daq.protocol.framing import FRAME_OVERHEAD_OCTETS, encode_frame
from daq.protocol.message import Message
from daq.protocol.messages import encode_message
from daq.protocol.replies import HelloReply, Refusal, StreamStartReply, WaveDataReply
from daq.protocol.reports import Stream

HELLO = Hello(proto_min=1, proto_max=1, cookie=0x1234)


def frame(seq: int, message: Message) -> bytes:
    return encode_frame(encode_message(seq, message))


@pytest.fixture
def device() -> DeviceLink:
    """A controller with 256 credits that has answered HELLO number 0."""
    device = DeviceLink(rx_credits=256)
    device.receive(frame(0, HELLO))
    numbers = {field.name: 0 for field in fields(HelloReply) if field.name != "bauds"}
    device.reply(0, HelloReply(bauds=(), **numbers))
    device.take_output()
    return device


def test_a_host_over_its_credits_is_refused_and_counted(device: DeviceLink) -> None:
    big = WaveData(slot=0, offset=0, words=bytes(192))
    assert device.receive(frame(1, big)) == [(1, big)]
    assert device.credits_free == 256 - 200 - FRAME_OVERHEAD_OCTETS
    assert device.receive(frame(2, big)) == []
    assert device.take_output() == frame(2, Refusal(command=WaveData.TYPE, status=StatusCode.NO_CREDIT))
    assert device.counters.rx_overruns == 1
    device.reply(1, WaveDataReply(status=0, slot=0, offset=0))
    assert device.credits_free == 256


def test_credits_below_one_longest_frame_are_refused() -> None:
    with pytest.raises(ValueError, match="rx_credits=255 must be at least 256"):
        DeviceLink(rx_credits=255)


def test_nothing_but_hello_and_estop_is_accepted_before_a_session() -> None:
    device = DeviceLink()
    assert device.receive(frame(4, Ping(cookie=1))) == []
    assert device.take_output() == frame(4, Refusal(command=Ping.TYPE, status=StatusCode.WRONG_SESSION))
    assert device.receive(frame(4, Estop())) == [(4, Estop())]


@pytest.mark.parametrize(
    ("message", "status", "counter"),
    [
        (b"\x3e\x07", StatusCode.UNKNOWN_COMMAND, "rx_unknown"),
        (b"\x03\x07\x01\x02", StatusCode.MALFORMED, "rx_malformed"),
    ],
)
def test_what_cannot_be_understood_is_refused_in_the_short_form(
    message: bytes, status: StatusCode, counter: str
) -> None:
    device = DeviceLink()
    assert device.receive(encode_frame(message)) == []
    assert device.take_output() == encode_frame(bytes([message[0] | 0x40, 7, status, 0]))
    assert getattr(device.counters, counter) == 1


def test_a_new_hello_drops_the_answers_to_what_came_before(device: DeviceLink) -> None:
    device.receive(frame(1, LinkStats()))
    device.receive(frame(77, Hello(proto_min=1, proto_max=1, cookie=6)))
    device.reply(1, Refusal(command=LinkStats.TYPE, status=StatusCode.BUSY))
    assert device.take_output() == b""


def test_stream_frames_are_numbered_from_zero_at_each_start(device: DeviceLink) -> None:
    batch = Stream(layout=1, batch=1, tick0=0, status=0, samples=bytes(6))
    for seq in (1, 2):
        device.receive(frame(seq, StreamStart()))
        device.reply(seq, StreamStartReply(status=0, tick=0))
        device.take_output()
        device.send(batch)
        device.send(batch)
        assert device.take_frames() == [frame(0, batch), frame(1, batch)]
