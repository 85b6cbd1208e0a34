"""Frames: damage is counted and skipped, whatever the octets and however they are cut."""

import zlib

import pytest
from cobs import cobs
from hypothesis import given
from hypothesis import strategies as st

from daq.protocol.framing import MAX_MESSAGE_OCTETS, FrameDecoder, encode_frame

messages = st.binary(min_size=1, max_size=MAX_MESSAGE_OCTETS // 2).map(lambda half: half + half)


def cut(data: bytes, marks: list[int]) -> list[bytes]:
    edges = sorted({0, len(data), *(mark % (len(data) + 1) for mark in marks)})
    return [data[a:b] for a, b in zip(edges, edges[1:], strict=False)]


@given(messages)
def test_a_frame_decodes_to_its_message(message: bytes) -> None:
    decoder = FrameDecoder()
    assert decoder.feed(encode_frame(message)) == [message]
    assert decoder.counters.dropped == 0


@given(messages)
def test_a_frame_holds_one_delimiter_and_six_octets_of_overhead(message: bytes) -> None:
    frame = encode_frame(message)
    assert frame.index(0) == len(frame) - 1
    assert len(frame) == len(message) + 6


@given(st.binary(max_size=2000))
def test_no_octets_raise(data: bytes) -> None:
    decoder = FrameDecoder()
    decoder.feed(data)
    parts = [part for part in data.split(b"\x00")[:-1] if part]
    assert decoder.counters.frames + decoder.counters.dropped == len(parts)


@given(st.binary(max_size=600), st.lists(messages, min_size=1, max_size=4))
def test_the_decoder_is_in_step_again_at_the_next_delimiter(noise: bytes, sent: list[bytes]) -> None:
    decoder = FrameDecoder()
    decoder.feed(noise)
    received = decoder.feed(b"\x00" + b"".join(encode_frame(message) for message in sent))
    assert received[-len(sent) :] == sent


@given(
    st.lists(st.one_of(st.binary(max_size=400), messages.map(encode_frame)), max_size=8),
    st.lists(st.integers(0), max_size=12),
)
def test_cutting_the_octets_changes_nothing(pieces: list[bytes], marks: list[int]) -> None:
    data = b"".join(pieces)
    whole, pieced = FrameDecoder(), FrameDecoder()
    expected = whole.feed(data)
    received = [message for piece in cut(data, marks) for message in pieced.feed(piece)]
    assert received == expected
    assert pieced.counters == whole.counters


@given(st.lists(messages, min_size=3, max_size=6), st.integers(0), st.integers(1, 255))
def test_one_corrupt_octet_costs_at_most_two_frames_and_invents_none(
    sent: list[bytes], position: int, flip: int
) -> None:
    wire = bytearray(b"".join(encode_frame(message) for message in sent))
    wire[position % len(wire)] ^= flip
    received = FrameDecoder().feed(bytes(wire))
    assert len(received) >= len(sent) - 2
    remaining = iter(sent)
    assert all(message in remaining for message in received)  # a subsequence of what was sent


def stuff(body: bytes) -> bytes:
    return bytes(cobs.encode(body)) + b"\x00"


def crc(message: bytes) -> bytes:
    return zlib.crc32(message).to_bytes(4, "little")


@pytest.mark.parametrize(
    ("wire", "counter"),
    [
        pytest.param(b"\x05\x01\x00", "malformed", id="COBS code beyond the end"),
        pytest.param(stuff(b"\x03" + crc(b"\x03")), "malformed", id="odd length"),
        pytest.param(stuff(crc(b"")), "malformed", id="no message"),
        pytest.param(stuff(b"\x03\x00\x01\x02\x03\x04"), "crc_errors", id="wrong CRC"),
        pytest.param(b"\x01" * 256 + b"\x00", "oversize", id="lost delimiter"),
    ],
)
def test_each_kind_of_damage_has_its_counter(wire: bytes, counter: str) -> None:
    decoder = FrameDecoder()
    assert decoder.feed(wire) == []
    assert getattr(decoder.counters, counter) == decoder.counters.dropped == 1


def test_repeated_delimiters_are_no_damage() -> None:
    decoder = FrameDecoder()
    assert decoder.feed(b"\x00\x00" + encode_frame(b"\x1b\x00") + b"\x00") == [b"\x1b\x00"]
    assert decoder.counters.dropped == 0


def test_an_endless_frame_takes_no_memory() -> None:
    decoder = FrameDecoder()
    for _ in range(100):
        decoder.feed(b"\x01" * 1000)
    decoder.feed(b"\x00")
    assert decoder.counters.oversize == 1
    assert decoder.feed(encode_frame(b"\x03\x00")) == [b"\x03\x00"]


def test_files_may_hold_longer_frames_than_the_wire() -> None:
    message = bytes(range(256)) * 16
    assert FrameDecoder(max_message=None).feed(encode_frame(message, max_message=None)) == [message]


@pytest.mark.parametrize("message", [b"", b"\x01", b"\x01" * (MAX_MESSAGE_OCTETS + 2)])
def test_a_message_of_wrong_length_is_refused(message: bytes) -> None:
    with pytest.raises(ValueError, match="octets"):
        encode_frame(message)
