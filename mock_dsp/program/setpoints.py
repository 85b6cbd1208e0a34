"""Streamed set-points: two halves of 256 words, one played while the host fills the other.

A half is free again when its last word has been played, so the host always has the time of one half
(256 words) to send the next. Playing begins when the first half is full. A player that runs out of words
says so; the drive then ramps to zero.
"""

import numpy as np
from numpy.typing import NDArray

from daq.protocol.codes import CURRENT_COUNT_A, SetpointFlag, StatusCode
from daq.protocol.message import MAX_DATA_OCTETS

HALF_WORDS = 256
BUFFER_WORDS = 2 * HALF_WORDS


class SetpointPlayer:
    """One stream of set-points, from SETPOINT_BEGIN to its end.

    Args:
        divisor: ticks that a word is held, at least 1.
        flags: bits of `SetpointFlag`.
    """

    def __init__(self, divisor: int, flags: int) -> None:
        self.divisor = divisor
        self.centring = bool(flags & SetpointFlag.CENTRING)
        self._words = np.zeros(BUFFER_WORDS, dtype=np.int16)
        self._received = 0
        self._played_ticks = 0

    @property
    def free(self) -> int:
        """Words that the host may send now."""
        freed = self.played // HALF_WORDS * HALF_WORDS
        return BUFFER_WORDS - (self._received - freed)

    @property
    def played(self) -> int:
        """Words whose time has passed."""
        return self._played_ticks // self.divisor

    @property
    def playing(self) -> bool:
        """Whether the first half has been full, which starts the output."""
        return self._received >= HALF_WORDS

    @property
    def ticks_left(self) -> int:
        """Ticks until the player runs out of words."""
        return self._received * self.divisor - self._played_ticks if self.playing else 0

    def append(self, first: int, octets: bytes, limit_a: float) -> StatusCode:
        """Take words (i16 counts, little endian); `first` counts from the beginning of the stream."""
        words = np.frombuffer(octets, dtype="<i2")
        if first != self._received & 0xFFFFFFFF or len(octets) > MAX_DATA_OCTETS:
            return StatusCode.OUT_OF_RANGE
        if len(words) > self.free:
            return StatusCode.NO_CREDIT
        if len(words) and np.abs(words.astype(np.int32)).max() * CURRENT_COUNT_A > limit_a:
            return StatusCode.OUT_OF_RANGE
        at = (self._received + np.arange(len(words))) % BUFFER_WORDS
        self._words[at] = words
        self._received += len(words)
        return StatusCode.OK

    def play(self, ticks: int) -> NDArray[np.float64]:
        """Return the next references in A, shape (ticks,); `ticks` is not more than `ticks_left`."""
        index = (self._played_ticks + np.arange(ticks)) // self.divisor
        self._played_ticks += ticks
        return self._words[index % BUFFER_WORDS] * np.float64(CURRENT_COUNT_A)
