"""How much of the line a stream takes: the arithmetic of docs/protocol.md, "Wire budget".

Nothing is measured here; the emulated controller's counters and a test show that the figures are right.
"""

from dataclasses import dataclass
from typing import Final

from daq.protocol.framing import FRAME_OVERHEAD_OCTETS, MAX_MESSAGE_OCTETS
from daq.protocol.stream import HEADER_OCTETS

LINE_USE_LIMIT: Final = 0.8
"""Largest share of the line that a stream may take; the rest carries replies, events, status and captures."""

_BITS_PER_OCTET: Final = 10  # start bit, eight data bits, stop bit
_WORD_OCTETS: Final = 2


def max_batch(channels: int) -> int:
    """Most samples of `channels` words that one frame can carry."""
    return (MAX_MESSAGE_OCTETS - HEADER_OCTETS) // (_WORD_OCTETS * channels)


def default_batch(channels: int) -> int:
    """Samples a frame when the host does not care: 25 (10 ms at divisor 1), or the most that fit."""
    return min(25, max_batch(channels))


def wire_octets(channels: int, batch: int) -> int:
    """Octets on the wire of one stream frame: header, samples, CRC, COBS and delimiter.

    Raises:
        ValueError: The frame would be too long.
    """
    if channels < 1 or not 1 <= batch <= max_batch(channels):
        raise ValueError(
            f"batch={batch} of {channels} channels must lie in 1 to {max_batch(max(channels, 1))}"
        )
    return HEADER_OCTETS + _WORD_OCTETS * channels * batch + FRAME_OVERHEAD_OCTETS


def wire_efficiency(channels: int, batch: int) -> float:
    """Share of the octets on the wire that are samples."""
    return _WORD_OCTETS * channels * batch / wire_octets(channels, batch)


def line_use(baud: int, channels: int, batch: int, divisor: int, tick_hz: int) -> float:
    """Share of the line that a stream takes; above 1.0 it cannot be sent.

    Args:
        baud: Bits per second, 8 data bits, no parity, one stop bit.
        channels: Words a sample.
        batch: Samples a frame.
        divisor: Ticks a sample.
        tick_hz: Ticks per second.
    """
    octets_per_s = wire_octets(channels, batch) * tick_hz / (divisor * batch)
    return octets_per_s * _BITS_PER_OCTET / baud


@dataclass(frozen=True, slots=True, kw_only=True)
class StreamProposal:
    """Stream settings that fit the line."""

    divisor: int
    batch: int
    line_use: float


def propose_stream(
    baud: int, channels: int, tick_hz: int, limit: float = LINE_USE_LIMIT, max_divisor: int = 2500
) -> StreamProposal | None:
    """Return the fastest stream of `channels` words that stays within `limit`, or None when none does.

    The default batch is kept where it is enough; the longest, with the least overhead, where only it fits.
    """
    for divisor in range(1, max_divisor + 1):
        for batch in (default_batch(channels), max_batch(channels)):
            use = line_use(baud, channels, batch, divisor, tick_hz)
            if use <= limit:
                return StreamProposal(divisor=divisor, batch=batch, line_use=use)
    return None
