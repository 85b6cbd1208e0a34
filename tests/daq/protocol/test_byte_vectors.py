"""The vectors of tests/vectors, written by hand from docs/protocol.md, against two decoders.

One is the code's; the other, here, is deliberately another: COBS octet by octet, CRC bit by bit.
"""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

from daq.protocol.codes import StatusCode
from daq.protocol.device_link import DeviceLink
from daq.protocol.framing import FrameDecoder, encode_frame
from daq.protocol.message import Command, Reply
from daq.protocol.messages import MESSAGES, decode_message, encode_message
from daq.protocol.replies import Refusal

VECTORS = Path(__file__).parents[2] / "vectors"
Vector = dict[str, Any]  # Any: parsed JSON


def load(file: str, key: str) -> list[Vector]:
    entries: list[Vector] = json.loads((VECTORS / file).read_text())[key]
    return entries


def octets(text: str) -> bytes:
    return bytes.fromhex(text.replace("|", ""))


def crc_bitwise(data: bytes) -> int:
    crc = 0xFFFFFFFF
    for octet in data:
        crc ^= octet
        for _ in range(8):
            crc = crc >> 1 ^ (0xEDB88320 if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


def unstuff(wire: bytes) -> bytes:
    assert wire[-1] == 0
    assert 0 not in wire[:-1]
    out, at = bytearray(), 0
    while at < len(wire) - 1:
        code = wire[at]
        out += wire[at + 1 : at + code]
        if code < 0xFF:
            out.append(0)
        at += code
    assert at == len(wire) - 1
    assert wire[0] == 0xFF or out[-1] == 0  # the zero appended in thought
    return bytes(out if wire[0] == 0xFF and len(out) == 254 else out[:-1])


FRAMES = [*load("frames.json", "frames"), *load("messages.json", "vectors")]
MESSAGE_VECTORS = load("messages.json", "vectors")
KNOWN = [vector for vector in MESSAGE_VECTORS if "fields" in vector]


def name_of(vector: Vector) -> str:
    return str(vector["name"])


def test_the_check_value_of_the_crc() -> None:
    assert crc_bitwise(b"123456789") == 0xCBF43926


@pytest.mark.parametrize("vector", FRAMES, ids=name_of)
def test_a_vector_is_right_in_itself(vector: Vector) -> None:
    message = octets(vector["message"])
    assert unstuff(octets(vector["wire"])) == message + crc_bitwise(message).to_bytes(4, "little")


@pytest.mark.parametrize("vector", FRAMES, ids=name_of)
def test_the_code_frames_as_the_vector_says(vector: Vector) -> None:
    message, wire = octets(vector["message"]), octets(vector["wire"])
    assert encode_frame(message) == wire
    assert FrameDecoder().feed(wire) == [message]


@pytest.mark.parametrize("vector", load("frames.json", "damaged"), ids=name_of)
def test_damage_is_counted_as_the_vector_says(vector: Vector) -> None:
    decoder = FrameDecoder()
    assert decoder.feed(octets(vector["octets"])) == [octets(message) for message in vector["messages"]]
    counters = asdict(decoder.counters)
    risen = {name for name in ("crc_errors", "malformed", "oversize") if counters[name]}
    assert risen == ({vector["counter"]} if vector["counter"] else set())


def fields_of(vector: Vector) -> Vector:
    """The vector's fields as the code holds them: octets and words from hexadecimal, lists as tuples."""
    fields = dict(vector["fields"])
    for name in ("data", "words", "samples"):
        if name in fields:
            fields[name] = bytes.fromhex(fields[name])
    if "bauds" in fields:
        fields["bauds"] = tuple(fields["bauds"])
    return fields


@pytest.mark.parametrize("vector", KNOWN, ids=name_of)
def test_the_code_reads_and_writes_the_fields_of_the_vector(vector: Vector) -> None:
    body = octets(vector["message"])
    seq, message = decode_message(body)
    fields = fields_of(vector)
    if isinstance(message, Refusal):
        fields["command"] = body[0] & 0x3F
    assert (seq, asdict(message)) == (vector["seq"], fields)
    assert encode_message(seq, message) == body


def test_every_message_has_a_vector() -> None:
    assert {octets(vector["message"])[0] for vector in KNOWN} == set(MESSAGES)


def test_a_controller_keeps_up_the_dialogue() -> None:
    link = DeviceLink(rx_credits=256)
    for step in load("dialogue.json", "steps"):
        commands = link.receive(octets(step["received"]))
        executed = [encode_message(seq, command) for seq, command in commands]
        assert executed == ([octets(step["executes"])] if step["executes"] else []), step["why"]
        for seq, command in commands:
            link.reply(seq, answer_of(step, command))
        assert link.take_output() == octets(step["sends"]), step["why"]


def answer_of(step: Vector, command: Command) -> Reply:
    _, reply = decode_message(octets(step["answers"]))
    assert isinstance(reply, Reply)
    assert reply.status in (StatusCode.OK, StatusCode.BUSY)
    assert isinstance(reply, Refusal) or reply.TYPE == command.TYPE | 0x40
    return reply
