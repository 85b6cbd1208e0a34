"""What a UART makes of octets that were sent at another baud than it samples at.

A pseudo-terminal has no baud, so a host that opens it at the wrong rate would never notice. The emulator
compares the rate the host set on its side with the modelled one and passes the octets through this model
where they differ. The tolerance of a real UART (about +-4 % for 8N1) follows from the sampling by itself:
921600 against 937500 is clean, 115200 against 937500 is noise.
"""

import math

BITS_PER_OCTET = 10  # 8N1: start bit, eight data bits, stop bit


def resample_octets(octets: bytes, sent_baud: int, sampled_baud: int) -> bytes:
    """Return what a receiver sampling at `sampled_baud` reads of `octets` sent at `sent_baud`, back to back.

    The receiver waits for a falling edge, samples each data bit in its middle, and takes the octet
    whatever its stop bit says, as a serial port without framing-error checks does.
    """
    if sent_baud == sampled_baud:
        return octets
    line = _line_levels(octets)
    bit = sent_baud / sampled_baud  # the receiver's bit, in bits of the sender
    received = bytearray()
    edge = _next_falling_edge(line, -1.0)
    while edge is not None:
        value = 0
        for index in range(8):
            value |= _level(line, edge + (index + 1.5) * bit) << index
        received.append(value)
        edge = _next_falling_edge(line, edge + 9.5 * bit)
    return bytes(received)


def _line_levels(octets: bytes) -> list[int]:
    """Return the level of every bit on the line, least significant data bit first."""
    levels: list[int] = []
    for octet in octets:
        levels += [0, *((octet >> index) & 1 for index in range(8)), 1]
    return levels


def _level(line: list[int], position: float) -> int:
    """Return the level at a time in sender's bits; the idle line is high."""
    index = int(position)
    return line[index] if index < len(line) else 1


def _next_falling_edge(line: list[int], after: float) -> int | None:
    """Return the bit, later than `after`, at whose beginning the line goes from high to low."""
    start = math.floor(after) + 1
    previous = line[start - 1] if 0 < start <= len(line) else 1
    for at in range(start, len(line)):
        if previous and not line[at]:
            return at
        previous = line[at]
    return None
