"""Frames on the wire: COBS(body) 0x00, the body being a message and its CRC-32; docs/protocol.md, "Frames".

This file knows nothing of what a message means. Damage is counted, never raised: a decoder that has lost
step is in step again at the next delimiter, because COBS keeps the octet 0x00 out of everything else.
"""

import zlib
from dataclasses import dataclass
from typing import Final

from cobs import cobs

DELIMITER: Final = b"\x00"
CRC_OCTETS: Final = 4
MAX_BODY_OCTETS: Final = 254
"""Message and CRC together: the largest body that COBS still codes with one octet of overhead."""
MAX_MESSAGE_OCTETS: Final = MAX_BODY_OCTETS - CRC_OCTETS
FRAME_OVERHEAD_OCTETS: Final = CRC_OCTETS + 2
"""What a frame adds to its message: CRC, one octet of COBS, delimiter."""
MAX_WIRE_OCTETS: Final = MAX_MESSAGE_OCTETS + FRAME_OVERHEAD_OCTETS
MIN_MESSAGE_OCTETS: Final = 2

_CRC_RESIDUE: Final = 0x2144DF1C
# The CRC-32 of any octets followed by their own CRC (little endian) is this constant, so a body is checked
# without cutting it in two.


@dataclass(slots=True, kw_only=True)
class FrameCounters:
    """What a decoder has seen since it was made; the numbers only go up.

    Attributes:
        octets: Octets fed in.
        frames: Frames that passed.
        crc_errors: Frames whose CRC was wrong.
        malformed: Frames that are no COBS, too short, or of odd length.
        oversize: Frames longer than the protocol allows (as a rule: a delimiter was lost).
    """

    octets: int = 0
    frames: int = 0
    crc_errors: int = 0
    malformed: int = 0
    oversize: int = 0

    @property
    def dropped(self) -> int:
        """Frames dropped for any cause."""
        return self.crc_errors + self.malformed + self.oversize


def encode_frame(body: bytes, max_message: int | None = MAX_MESSAGE_OCTETS) -> bytes:
    """Wrap one message for the wire: append the CRC, stuff by COBS, add the delimiter.

    Args:
        body: The message without CRC; an even number of octets.
        max_message: Largest accepted message; None for files, where frames of any length are allowed.

    Raises:
        ValueError: The message is empty, odd or too long.
    """
    if len(body) < MIN_MESSAGE_OCTETS or len(body) % 2:
        raise ValueError(f"message of {len(body)} octets must have an even number of at least 2; pad it")
    if max_message is not None and len(body) > max_message:
        raise ValueError(f"message of {len(body)} octets exceeds {max_message}; send it in parts")
    stuffed: bytes = cobs.encode(body + zlib.crc32(body).to_bytes(CRC_OCTETS, "little"))
    return stuffed + DELIMITER


class FrameDecoder:
    """Turns received octets, in pieces of any size, into the messages that arrived whole.

    Args:
        max_message: Longest message to accept; None for files, where frames of any length are allowed.
    """

    def __init__(self, max_message: int | None = MAX_MESSAGE_OCTETS) -> None:
        self.counters = FrameCounters()
        self._tail = b""
        self._max_stuffed: int | None = None
        if max_message is not None:
            max_body = max_message + CRC_OCTETS
            self._max_stuffed = max_body + (max_body + 253) // 254  # COBS adds one octet for each 254 begun

    def feed(self, data: bytes) -> list[bytes]:
        """Return the messages (without CRC) completed by `data`, in order of arrival."""
        self.counters.octets += len(data)
        parts = (self._tail + data).split(DELIMITER)
        tail = parts.pop()
        if self._max_stuffed is not None and len(tail) > self._max_stuffed:
            # Too long already. One octet too many is enough to remember that, whatever still comes.
            tail = tail[: self._max_stuffed + 1]
        self._tail = tail
        return self._decode_parts(parts)

    def _decode_parts(self, parts: list[bytes]) -> list[bytes]:
        messages: list[bytes] = []
        counters, limit = self.counters, self._max_stuffed
        for part in parts:
            if not part:  # repeated delimiters are legal: they flush the line
                continue
            if limit is not None and len(part) > limit:
                counters.oversize += 1
                continue
            try:
                body: bytes = cobs.decode(part)
            except cobs.DecodeError:
                counters.malformed += 1
                continue
            if len(body) < MIN_MESSAGE_OCTETS + CRC_OCTETS or len(body) % 2:
                counters.malformed += 1
            elif zlib.crc32(body) != _CRC_RESIDUE:
                counters.crc_errors += 1
            else:
                messages.append(body[:-CRC_OCTETS])
        counters.frames += len(messages)
        return messages
