"""Octets of live frames, against docs/live.md, and the rows that they carry."""

import struct

import numpy as np
import pytest

from server.services.viewing.decimation import min_max_rows
from server.services.viewing.frame import FrameFlag, LiveFrame, decode_live, encode_live

FRAME = LiveFrame(
    plan=3,
    flags=FrameFlag.BREAK,
    samples_per_row=1,
    first_tick=2**32 + 5,
    row_s=4e-4,
    dropped=7,
    lost=8,
    newest_ns=9,
    sent_ns=10,
    number=11,
    values=np.array([[1.0, 2.0], [3.0, 4.0]], np.float32),
)


def test_octets_are_those_of_the_documentation() -> None:
    octets = encode_live(FRAME)
    assert octets[:16] == b"JSLV" + struct.pack("<6H", 1, 80, 3, 2, 2, 0)
    assert struct.unpack_from("<IIqd", octets, 16) == (2, 1, 2**32 + 5, 4e-4)
    assert struct.unpack_from("<QQqqQ", octets, 40) == (7, 8, 9, 10, 11)
    assert struct.unpack_from("<4f", octets, 80) == (1.0, 2.0, 3.0, 4.0)
    assert len(octets) == 96


def test_a_frame_is_read_back() -> None:
    again = decode_live(encode_live(FRAME))
    np.testing.assert_array_equal(again.values, FRAME.values)
    assert (again.first_tick, again.flags, again.number) == (2**32 + 5, FrameFlag.BREAK, 11)


@pytest.mark.parametrize("octets", [b"", b"NONE" + bytes(76), encode_live(FRAME)[:-1]])
def test_what_is_no_frame_is_refused(octets: bytes) -> None:
    with pytest.raises(ValueError, match="octets"):
        decode_live(octets)


def test_least_and_greatest_of_each_bucket_keep_every_peak() -> None:
    samples = np.array([[0.0, 5.0, 1.0, -1.0, 2.0], [9.0, 8.0, 7.0, 6.0, 5.0]])
    rows = min_max_rows(samples, 2)
    np.testing.assert_array_equal(rows, [[0, -1, 2], [5, 1, 2], [8, 6, 5], [9, 7, 5]])


def test_no_samples_give_no_rows() -> None:
    assert min_max_rows(np.empty((2, 0)), 4).shape == (4, 0)
