"""The sample stream: blocks of the fast loop's words in, message bodies out, many frames in one go.

Sample k of a stream that started at tick s is taken at s + k * divisor. A frame holds `batch` samples and no
more than one header; what does not fill a frame waits for the next block.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from daq.protocol.codes import StatusCode
from daq.protocol.dictionary_entries import Layout
from daq.protocol.framing import MAX_MESSAGE_OCTETS
from daq.protocol.reports import Stream
from mock_dsp.program.dictionary import LAYOUTS

Words = NDArray[np.uint16]

HEADER_WORDS = 5
_LAYOUTS: Mapping[int, Layout] = {layout.id: layout for layout in LAYOUTS}


@dataclass(frozen=True, slots=True, kw_only=True)
class StreamSettings:
    """What STREAM_CONFIG sets."""

    layout: Layout = LAYOUTS[0]
    divisor: int = 1
    batch: int = 25


def check_settings(layout: int, divisor: int, batch: int) -> StreamSettings | StatusCode:
    """Return the settings, or why they are refused."""
    entry = _LAYOUTS.get(layout)
    if entry is None or divisor < 1 or not 1 <= batch <= largest_batch(entry):
        return StatusCode.OUT_OF_RANGE
    return StreamSettings(layout=entry, divisor=divisor, batch=batch)


def largest_batch(layout: Layout) -> int:
    """Return how many samples of a layout fit into one frame."""
    return (MAX_MESSAGE_OCTETS // 2 - HEADER_WORDS) // len(layout.channels)


class StreamEncoder:
    """Samples waiting for their frame, and the frames' headers.

    Attributes:
        settings: layout, divisor and batch in force.
        running: whether samples are taken.
        tick_offset: added to the ticks in the headers; flush before it changes, since one frame has one tick.
    """

    def __init__(self) -> None:
        self.settings = StreamSettings()
        self.running = False
        self.tick_offset = 0
        self._start_tick = 0
        self._seq = 0
        self._pending: Words = np.empty((0, 0), dtype=np.uint16)
        self._pending_tick = 0

    def start(self, tick: int) -> None:
        """Begin with the sample at `tick`."""
        self.running = True
        self._seq = 0
        self._start_tick = tick
        self._drop_pending()

    def next_sample(self, tick: int) -> int:
        """Return the tick of the first sample at `tick` or later."""
        return tick + (self._start_tick - tick) % self.settings.divisor

    def stop(self) -> None:
        """End the stream; flush it first, or the samples that wait are lost."""
        self.running = False
        self._drop_pending()

    def flush(self, status: int) -> list[bytes]:
        """Return the samples that wait as one shorter frame; none if there are none."""
        if not len(self._pending):
            return []
        bodies = self._pack(self._pending, self._pending_tick, status, len(self._pending))
        self._drop_pending()
        return bodies

    def feed(self, tick: int, channels: Mapping[str, Words], status: int) -> list[bytes]:
        """Take a block of samples and return the frames it completes, without CRC.

        Args:
            tick: tick of the block's first sample.
            channels: one word per tick and channel, each of shape (n,).
            status: the frames' status word.
        """
        divisor = self.settings.divisor
        first = (self._start_tick - tick) % divisor
        chosen = [channels[name][first::divisor] for name in self.settings.layout.channels]
        if not len(chosen[0]):
            return []
        rows = np.stack(chosen, axis=1)
        if len(self._pending):
            rows = np.concatenate((self._pending, rows))
        else:
            self._pending_tick = tick + first
        batch = self.settings.batch
        whole = len(rows) // batch * batch
        bodies = self._pack(rows[:whole], self._pending_tick, status, batch) if whole else []
        self._pending = rows[whole:]
        self._pending_tick += whole * divisor
        return bodies

    def _pack(self, rows: Words, tick0: int, status: int, batch: int) -> list[bytes]:
        """Return the bodies of `len(rows) / batch` frames."""
        frames = len(rows) // batch
        index = np.arange(frames, dtype=np.int64)
        ticks = (tick0 + self.tick_offset + index * (batch * self.settings.divisor)) & 0xFFFFFFFF
        words = np.empty((frames, HEADER_WORDS + rows.size // frames), dtype="<u2")
        words[:, 0] = Stream.TYPE | ((self._seq + index) & 0xFF) << 8
        words[:, 1] = self.settings.layout.id | batch << 8
        words[:, 2] = ticks & 0xFFFF
        words[:, 3] = ticks >> 16
        words[:, 4] = status
        words[:, HEADER_WORDS:] = rows.reshape(frames, -1)
        self._seq = (self._seq + frames) & 0xFF
        octets, size = words.tobytes(), 2 * words.shape[1]
        return [octets[at : at + size] for at in range(0, len(octets), size)]

    def _drop_pending(self) -> None:
        self._pending = np.empty((0, len(self.settings.layout.channels)), dtype=np.uint16)
