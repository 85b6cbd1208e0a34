"""Messages: every class survives the way through octets; what is no message is a FrameError, nothing else."""

import dataclasses
import struct
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from daq.errors import FrameError
from daq.protocol.codes import SUCCESSES, StatusCode
from daq.protocol.commands import DictRead, Disarm, ParamSet, Ping, WaveData
from daq.protocol.framing import MAX_MESSAGE_OCTETS
from daq.protocol.message import REPLY_BIT, Message, Tail
from daq.protocol.messages import EXCHANGES, MESSAGES, REPORTS, decode_message, encode_message
from daq.protocol.replies import DisarmReply, ParamSetReply, Refusal

_RANGES = {
    "B": (0, 255),
    "H": (0, 65535),
    "h": (-32768, 32767),
    "I": (0, 2**32 - 1),
    "i": (-(2**31), 2**31 - 1),
}
_TAILS: dict[Tail, st.SearchStrategy[bytes | tuple[int, ...]]] = {
    Tail.OCTETS: st.binary(max_size=192),
    Tail.WORDS: st.binary(max_size=96).map(lambda half: half + half),
    Tail.REST: st.binary(max_size=120).map(lambda half: half + half),
    Tail.RATES: st.lists(st.integers(0, 2**32 - 1), max_size=20).map(tuple),
}


def messages_of(kind: type[Message]) -> st.SearchStrategy[Message]:
    names = [field.name for field in dataclasses.fields(kind)]
    values: dict[str, st.SearchStrategy[object]] = {
        name: st.integers(*_RANGES[code]) for name, code in zip(names, kind.FORMAT, strict=False)
    }
    if kind.TAIL is not Tail.NONE:
        values[names[-1]] = _TAILS[kind.TAIL]
    return st.builds(kind, **values)


@pytest.mark.parametrize("kind", MESSAGES.values(), ids=lambda kind: kind.__name__)
@given(data=st.data(), seq=st.integers(0, 255))
def test_a_message_survives_the_way_through_octets(
    kind: type[Message], data: st.DataObject, seq: int
) -> None:
    message = data.draw(messages_of(kind))
    body = encode_message(seq, message)
    assert decode_message(body) == (seq, message)
    assert len(body) % 2 == 0
    assert len(body) <= MAX_MESSAGE_OCTETS


@given(st.binary(min_size=0, max_size=MAX_MESSAGE_OCTETS))
def test_octets_that_are_no_message_are_a_frame_error(body: bytes) -> None:
    with suppress(FrameError):
        seq, message = decode_message(body)
        assert encode_message(seq, message)[:2] == body[:2]


@pytest.mark.parametrize("kind", MESSAGES.values(), ids=lambda kind: kind.__name__)
def test_a_message_cut_short_is_a_frame_error(kind: type[Message]) -> None:
    size = struct.calcsize("<BB" + kind.FORMAT)
    for length in range(2, size, 2):
        with pytest.raises(FrameError, match="shorter"):
            decode_message(bytes([kind.TYPE]) + bytes(length - 1))


def test_an_overlong_message_is_a_frame_error() -> None:
    with pytest.raises(FrameError, match="longer"):
        decode_message(encode_message(0, Disarm()) + b"\x00\x00")


def test_a_tail_of_another_length_than_announced_is_a_frame_error() -> None:
    body = encode_message(1, WaveData(slot=0, offset=0, words=b"\x01\x00\x02\x00"))
    with pytest.raises(FrameError, match="announces 4 octets in its last field but carries 2"):
        decode_message(body[:-2])


def test_an_unknown_type_is_a_frame_error() -> None:
    with pytest.raises(FrameError, match="0x3e"):
        decode_message(b"\x3e\x00")


@pytest.mark.parametrize("status", [status for status in StatusCode if status not in SUCCESSES])
def test_a_refusal_may_be_its_status_alone(status: StatusCode) -> None:
    refusal = Refusal(command=Ping.TYPE, status=status)
    assert decode_message(encode_message(9, refusal)) == (9, refusal)


def test_a_refusal_may_also_carry_its_fields() -> None:
    reply = ParamSetReply(status=StatusCode.NOT_WRITABLE, parameter=3, raw=-7)
    assert decode_message(encode_message(9, reply)) == (9, reply)


def test_a_success_without_its_fields_is_a_frame_error() -> None:
    with pytest.raises(FrameError, match="shorter"):
        decode_message(bytes([Ping.TYPE | REPLY_BIT, 0, StatusCode.OK, 0]))


def test_a_reply_without_fields_keeps_its_class_when_refused() -> None:
    assert decode_message(bytes([0x5A, 1, StatusCode.WRONG_STATE, 0])) == (1, DisarmReply(status=5))


@pytest.mark.parametrize(
    "message",
    [
        ParamSet(parameter=1, raw=2**31),
        DictRead(offset=-1, count=2),
        WaveData(slot=0, offset=0, words=b"\x01"),
    ],
)
def test_a_value_that_does_not_fit_is_refused(message: Message) -> None:
    with pytest.raises(ValueError, match="fit|whole number"):
        encode_message(0, message)


def test_types_tell_commands_replies_and_reports_apart() -> None:
    for command, reply in EXCHANGES:
        assert 0 < command.TYPE < REPLY_BIT
        assert reply.TYPE == command.TYPE | REPLY_BIT
        assert reply.__name__ == command.__name__ + "Reply"
    assert all(report.TYPE >= 0x80 for report in REPORTS)
    assert len(MESSAGES) == 2 * len(EXCHANGES) + len(REPORTS)


@pytest.mark.parametrize("kind", MESSAGES.values(), ids=lambda kind: kind.__name__)
def test_every_field_is_aligned_to_16_bits(kind: type[Message]) -> None:
    octets = "BB" + kind.FORMAT
    assert octets.replace("BB", "").count("B") == 0
    assert struct.calcsize("<" + octets) % 2 == 0
