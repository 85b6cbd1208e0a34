"""What a UART reads of octets sent at another rate."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mock_dsp.wire.uart import resample_octets


@given(octets=st.binary(max_size=200))
@pytest.mark.parametrize(("sent", "sampled"), [(937_500, 921_600), (115_200, 114_329), (460_800, 468_750)])
def test_rates_within_two_percent_are_read_without_error(octets: bytes, sent: int, sampled: int) -> None:
    assert resample_octets(octets, sent, sampled) == octets


def test_a_slow_receiver_merges_the_bits_of_a_fast_sender() -> None:
    # One start bit of 115200 Bd lasts as long as eight bits and a stop bit of 937500 Bd: a whole octet 0x00
    # and most of its successor are one low level to the receiver.
    assert len(resample_octets(bytes(80), 937_500, 115_200)) == 10


def test_a_fast_receiver_sees_each_slow_bit_as_many() -> None:
    # The start bit alone, 8.1 receiver's bits long, is read as 0x00 with the last data bit on the edge.
    received = resample_octets(b"\xff", 115_200, 937_500)
    assert received == b"\x80"


@given(octets=st.binary(max_size=60), sent=st.integers(9600, 4_000_000), sampled=st.integers(9600, 4_000_000))
def test_no_pair_of_rates_raises(octets: bytes, sent: int, sampled: int) -> None:
    resample_octets(octets, sent, sampled)
