"""Sensor noise as a function of (seed, tick), so that the size of blocks cannot change it."""

import numpy as np

from mock_dsp.physics.layout import NOISE_COLUMNS

CHUNK_TICKS = 4096


class NoiseSource:
    """Standard normal numbers for each tick, from a counter-based generator.

    Chunk c of 4096 ticks comes from Philox with the key (seed, c): any chunk can be made again without those
    before it, and nothing depends on how ticks are asked for.
    """

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._chunk = -1
        self._values = np.empty((0, NOISE_COLUMNS))

    def take(self, tick: int, count: int) -> np.ndarray:
        """Return up to `count` rows from `tick` on, shape (m, 3); m < count at the end of a chunk."""
        chunk, offset = divmod(tick, CHUNK_TICKS)
        if chunk != self._chunk:
            key = np.array([self._seed, chunk], dtype=np.uint64)
            generator = np.random.Generator(np.random.Philox(key=key))
            self._values = generator.standard_normal((CHUNK_TICKS, NOISE_COLUMNS))
            self._chunk = chunk
        return self._values[offset : offset + count]
