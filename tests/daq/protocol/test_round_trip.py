"""The waiting time for replies."""

import pytest

from daq.protocol.round_trip import LinkOptions, RoundTripTimer

MS = 1_000_000


def test_the_wait_is_that_of_rfc_6298() -> None:
    timer = RoundTripTimer(LinkOptions())
    timer.observe(100 * MS)
    assert timer.wait_ns(1) == (100 + 4 * 50) * MS
    timer.observe(200 * MS)  # mean 100 + 100/8 = 112.5 ms, deviation 50 + (100 - 50)/4 = 62.5 ms
    assert timer.wait_ns(1) == 362_500_000


@pytest.mark.parametrize(
    "options", [{"tries": 0}, {"rto_min_ns": 0}, {"rto_min_ns": 2_000_000_000}, {"first_seq": 256}]
)
def test_options_out_of_range_are_refused(options: dict[str, int]) -> None:
    with pytest.raises(ValueError, match="must"):
        LinkOptions(**options)
