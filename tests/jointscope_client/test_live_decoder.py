"""The client's decoder of live data, against frames written by hand from docs/live.md."""

import json
import struct

import numpy as np
import pytest

from jointscope_client.errors import ClientError, InvalidError
from jointscope_client.live import LiveDecoder, live_url

PLAN = {
    "type": "plan",
    "plan": 7,
    "rig": "emulated",
    "columns": [{"name": "current_A", "unit": "A"}, {"name": "speed_rad_s", "unit": "rad/s"}],
    "rate_hz": None,
    "interval_ms": 50,
    "tick_hz": 2500,
}


def frame(values: list[list[float]], *, flags: int = 0, version: int = 1, header: int = 80) -> bytes:
    """Return a frame field by field, as the table of docs/live.md lists them."""
    parts = [
        b"JSLV",
        struct.pack("<H", version),
        struct.pack("<H", header),
        struct.pack("<H", 7),  # plan
        struct.pack("<H", flags),
        struct.pack("<H", len(values)),
        struct.pack("<H", 0),
        struct.pack("<I", len(values[0])),
        struct.pack("<I", 5),  # samples a row stands for
        struct.pack("<q", 2**40),
        struct.pack("<d", 0.002),
        struct.pack("<Q", 11),
        struct.pack("<Q", 22),
        struct.pack("<q", 33),
        struct.pack("<q", 44),
        struct.pack("<Q", 55),
        b"\0" * (header - 80),
        *(struct.pack(f"<{len(each)}f", *each) for each in values),
    ]
    return b"".join(parts)


@pytest.fixture
def decoder() -> LiveDecoder:
    made = LiveDecoder()
    assert made.feed(json.dumps(PLAN)) is None
    return made


def test_a_frame_is_read_field_by_field(decoder: LiveDecoder) -> None:
    read = decoder.feed(frame([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], flags=2))
    assert read is not None
    assert np.array_equal(read["current_A"], [1.0, 2.0, 3.0])
    assert np.array_equal(read["speed_rad_s"], [4.0, 5.0, 6.0])
    assert (read.units["speed_rad_s"], read.rows, read.samples_per_row) == ("rad/s", 3, 5)
    assert (read.tick, read.row_time_s, read.after_hole) == (2**40, 0.002, True)
    assert (read.lost, read.missing, read.newest_ns, read.made_ns, read.number) == (11, 22, 33, 44, 55)


def test_least_and_greatest_values_have_columns_of_their_own(decoder: LiveDecoder) -> None:
    read = decoder.feed(frame([[1.0], [2.0], [3.0], [4.0]], flags=1))
    assert read is not None
    assert {name: float(values[0]) for name, values in read.columns.items()} == {
        "current_A_min": 1.0,
        "current_A_max": 2.0,
        "speed_rad_s_min": 3.0,
        "speed_rad_s_max": 4.0,
    }


def test_a_longer_header_is_skipped_and_a_frame_without_rows_read(decoder: LiveDecoder) -> None:
    for octets in (frame([[], []], header=96), frame([[], []])[:12] + b"\0\0" + frame([[], []])[14:]):
        read = decoder.feed(octets)
        assert read is not None
        assert (read.rows, len(read["current_A"])) == (0, 0)


def test_another_version_is_refused(decoder: LiveDecoder) -> None:
    with pytest.raises(ClientError, match="version 2"):
        decoder.feed(frame([[1.0], [1.0]], version=2))


def test_a_choice_that_is_refused_is_told(decoder: LiveDecoder) -> None:
    with pytest.raises(InvalidError, match="no such column") as told:
        decoder.feed(json.dumps({"type": "problem", "field": "columns", "detail": "no such column"}))
    assert told.value.field == "columns"


def test_the_address_is_the_services_own() -> None:
    url = live_url("https://bench:8443", "rig 1", ["current_A", "speed_rad_s"], 100.0, 20)
    start, _, query = url.partition("?")
    assert start == "wss://bench:8443/api/v1/rigs/rig%201/live"
    assert query == "interval_ms=20&columns=current_A%2Cspeed_rad_s&rate_hz=100.0"
