"""The arithmetic of line use, against the octets of real frames and against hand-computed figures."""

import pytest

from daq.protocol.budget import (
    LINE_USE_LIMIT,
    StreamProposal,
    default_batch,
    line_use,
    max_batch,
    propose_stream,
    wire_efficiency,
    wire_octets,
)
from daq.protocol.framing import encode_frame
from daq.protocol.messages import encode_message
from daq.protocol.reports import Stream


@pytest.mark.parametrize("channels", [1, 2, 3, 4, 5, 6])
@pytest.mark.parametrize("longest", [True, False])
def test_wire_octets_are_those_of_a_frame(channels: int, longest: bool) -> None:
    batch = max_batch(channels) if longest else default_batch(channels)
    frame = Stream(layout=1, batch=batch, tick0=1, status=2, samples=bytes(2 * channels * batch))
    assert wire_octets(channels, batch) == len(encode_frame(encode_message(0, frame)))


def test_the_longest_batch_fills_the_frame() -> None:
    assert [max_batch(channels) for channels in (3, 4, 5)] == [40, 30, 24]
    with pytest.raises(ValueError, match="batch=41 of 3 channels must lie in 1 to 40"):
        wire_octets(3, 41)


def test_figures_computed_by_hand() -> None:
    # 25 samples of 3 words: 10 + 150 + 4 + 2 = 166 octets, 100 frames a second, 10 bits an octet.
    assert wire_octets(3, 25) == 166
    assert wire_efficiency(3, 25) == pytest.approx(150 / 166)
    assert line_use(230_400, 3, 25, 1, 2500) == pytest.approx(166_000 / 230_400)
    assert line_use(115_200, 3, 25, 1, 2500) == pytest.approx(166_000 / 115_200)


@pytest.mark.parametrize(
    ("baud", "channels", "divisor", "batch"), [(115_200, 3, 2, 25), (115_200, 4, 3, 25), (937_500, 5, 1, 24)]
)
def test_the_proposal_is_the_fastest_that_fits(baud: int, channels: int, divisor: int, batch: int) -> None:
    proposal = propose_stream(baud, channels, 2500)
    use = line_use(baud, channels, batch, divisor, 2500)
    assert proposal == StreamProposal(divisor=divisor, batch=batch, line_use=use)
    assert use <= LINE_USE_LIMIT
    assert divisor == 1 or line_use(baud, channels, max_batch(channels), divisor - 1, 2500) > LINE_USE_LIMIT


def test_a_longer_batch_is_proposed_where_only_it_fits() -> None:
    # 2 words at 2500 1/s and 144 000 Bd: 116 octets for 25 samples are 80.6 %, 256 octets for 60 are 74.1 %.
    proposal = propose_stream(144_000, 2, 2500)
    assert proposal is not None
    assert (proposal.divisor, proposal.batch) == (1, 60)
    assert proposal.line_use == pytest.approx(256 / 60 * 25_000 / 144_000)


def test_no_proposal_for_a_hopeless_line() -> None:
    assert propose_stream(10, 3, 2500, max_divisor=10) is None
