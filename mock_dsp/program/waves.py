"""The two slots for uploaded tables: begin, fill, check the CRC, and only then playable."""

import zlib
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from daq.protocol.codes import StatusCode
from daq.protocol.message import MAX_DATA_OCTETS

SLOTS = 2
MAX_WORDS = 1024


@dataclass(slots=True)
class _Slot:
    octets: bytearray = field(default_factory=bytearray)
    filled: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    crc: int = 0
    words: NDArray[np.int16] | None = None


class WaveTables:
    """Tables of current words (i16 counts), uploaded in pieces in any order, repeated pieces included."""

    def __init__(self) -> None:
        self._slots = [_Slot() for _ in range(SLOTS)]

    def begin(self, slot: int, length: int, crc: int) -> StatusCode:
        """Open a slot for `length` words; what it held is gone."""
        if slot >= SLOTS or not 1 <= length <= MAX_WORDS:
            return StatusCode.OUT_OF_RANGE
        nothing_yet = np.zeros(length, dtype=np.bool_)
        self._slots[slot] = _Slot(octets=bytearray(2 * length), filled=nothing_yet, crc=crc)
        return StatusCode.OK

    def fill(self, slot: int, offset: int, octets: bytes) -> StatusCode:
        """Put words (little endian) at word `offset` of an open slot."""
        if slot >= SLOTS:
            return StatusCode.OUT_OF_RANGE
        target = self._slots[slot]
        if not target.octets or target.words is not None:
            return StatusCode.NO_DATA
        end = offset + len(octets) // 2
        if end > len(target.filled) or len(octets) > MAX_DATA_OCTETS:
            return StatusCode.OUT_OF_RANGE
        target.octets[2 * offset : 2 * end] = octets
        target.filled[offset:end] = True
        return StatusCode.OK

    def commit(self, slot: int) -> StatusCode:
        """Make an open slot playable if every word arrived and the CRC fits."""
        if slot >= SLOTS:
            return StatusCode.OUT_OF_RANGE
        target = self._slots[slot]
        if not target.octets or not target.filled.all():
            return StatusCode.NO_DATA
        if zlib.crc32(target.octets) != target.crc:
            return StatusCode.BAD_CRC
        target.words = np.frombuffer(bytes(target.octets), dtype="<i2").astype(np.int16)
        return StatusCode.OK

    def words(self, slot: int) -> NDArray[np.int16] | None:
        """Return a playable table's words, shape (length,); None if the slot holds none."""
        return self._slots[slot].words if slot < SLOTS else None
