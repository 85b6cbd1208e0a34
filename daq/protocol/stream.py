"""From stream frames to blocks of samples on a 64-bit time axis; docs/protocol.md, "Stream".

The fast path: a whole read's worth of frames of one shape becomes one block, its headers and samples read
by numpy in one go, so that the cost per frame is that of joining octets. Counts stay counts;
`daq.calibration` makes SI of them.

The assembler reads four replies beside the stream frames (STREAM_CONFIG, STREAM_START, STREAM_STOP, HELLO).
They tell it the divisor, where a stream begins and ends, and that the controller has restarted; so a
journal of received frames replays to the very blocks that were seen live, without any other knowledge.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import groupby
from typing import Final

import numpy as np
from numpy.typing import NDArray

from daq.errors import FrameError
from daq.protocol.codes import StatusCode
from daq.protocol.dictionary import Dictionary
from daq.protocol.messages import decode_message
from daq.protocol.replies import HelloReply, StreamConfigReply, StreamStartReply, StreamStopReply
from daq.protocol.reports import Stream
from daq.protocol.tick_axis import Gap, GapCause, TickAxis

STREAM_TYPES: Final = frozenset(
    kind.TYPE for kind in (Stream, StreamConfigReply, StreamStartReply, StreamStopReply, HelloReply)
)
"""Types of the messages that the assembler reads; it passes over all others."""

LINK_LOST: Final = b"\xff"
"""Stands between messages where the link was lost: what is missing up to the next sample is missing for that. No
message is a single octet."""

HEADER_OCTETS: Final = 10


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SampleBlock:
    """Samples of one layout, in the order in which they were taken.

    Attributes:
        layout: Name of the layout.
        divisor: Ticks from one sample to the next, but for gaps.
        ticks: Tick of each sample on the 64-bit axis, int64, shape (n,).
        counts: Raw words by channel name, int16 or uint16, each of shape (n,).
        status: Status word of each frame, uint16, shape (frames,); all frames have n / frames samples.
        gaps: Holes before or between these samples, oldest first. A block may have gaps and no samples.
    """

    layout: str
    divisor: int
    ticks: NDArray[np.int64]
    counts: dict[str, NDArray[np.int16] | NDArray[np.uint16]]
    status: NDArray[np.uint16]
    gaps: tuple[Gap, ...]


@dataclass(slots=True, kw_only=True)
class StreamCounters:
    """What the assembler has seen; the numbers only go up.

    Attributes:
        frames: Stream frames whose samples were taken over.
        samples: Samples taken over.
        malformed: Stream frames of unknown layout or of a length that does not fit their header.
        repeated: Stream frames dropped because their samples had been received before.
        missing_samples: Samples known to be missing.
    """

    frames: int = 0
    samples: int = 0
    malformed: int = 0
    repeated: int = 0
    missing_samples: int = 0


class _Reader:
    """How frames of one layout are read.

    Args:
        name: Name of the layout.
        channels: Names and numpy types of its words.
    """

    def __init__(
        self, name: str, channels: Sequence[tuple[str, np.dtype[np.int16] | np.dtype[np.uint16]]]
    ) -> None:
        self.name = name
        self.channels = tuple(channels)

    def frame_octets(self, batch: int) -> int:
        """Length of a message with `batch` samples."""
        return HEADER_OCTETS + 2 * len(self.channels) * batch

    def split(self, words: NDArray[np.int16]) -> dict[str, NDArray[np.int16] | NDArray[np.uint16]]:
        """Cut words of shape (n, channels) into channels."""
        columns = np.ascontiguousarray(words.T)
        return {name: columns[i].view(dtype) for i, (name, dtype) in enumerate(self.channels)}


class StreamAssembler:
    """Makes blocks of samples out of received messages.

    Args:
        dictionary: The controller's dictionary: layouts and their channels.
    """

    def __init__(self, dictionary: Dictionary) -> None:
        self.counters = StreamCounters()
        self._axis = TickAxis()
        self._session: int | None = None
        self._readers = {
            layout.id: _Reader(
                layout.name, [(name, dictionary.channel(name).type.dtype) for name in layout.channels]
            )
            for layout in dictionary.layouts
        }
        self._last_layout = dictionary.layouts[0].name if dictionary.layouts else ""

    def feed(self, bodies: Sequence[bytes]) -> list[SampleBlock]:
        """Take received messages in their order and return the blocks they complete.

        Args: bodies: Messages without CRC, as `FrameDecoder.feed` returns them, and `LINK_LOST`; those of no
            concern are passed over.
        """
        blocks = [block for run in _runs(bodies) if (block := self._read_run(run)) is not None]
        gaps = self._axis.take_gaps()
        if gaps:  # found by a reply, not by a frame: a stream's end or a new session
            blocks.append(
                self._block(self._last_layout, np.empty(0, np.int64), {}, np.empty(0, np.uint16), gaps)
            )
        self.counters.repeated = self._axis.repeated
        self.counters.missing_samples = self._axis.missing_samples
        return blocks

    def _read_run(self, run: Sequence[bytes]) -> SampleBlock | None:
        if run[0][0] != Stream.TYPE:
            for body in run:
                self._heed_reply(body)
            return None
        reader = self._readers.get(run[0][2]) if len(run[0]) >= HEADER_OCTETS else None
        batch = run[0][3] if reader else 0
        if reader is None or batch == 0 or len(run[0]) != reader.frame_octets(batch):
            self.counters.malformed += len(run)
            return None
        return self._read_frames(
            reader, np.frombuffer(b"".join(run), _frame_dtype(batch, len(reader.channels))), batch
        )

    def _read_frames(self, reader: _Reader, frames: NDArray[np.void], batch: int) -> SampleBlock | None:
        starts = self._axis.place(frames["seq"], frames["tick0"], batch)
        if (starts < 0).any():
            frames, starts = frames[starts >= 0], starts[starts >= 0]
        if not len(starts):
            return None
        ticks = (starts[:, None] + np.arange(batch, dtype=np.int64) * self._axis.divisor).reshape(-1)
        counts = reader.split(frames["words"].reshape(len(ticks), -1))
        self.counters.frames += len(starts)
        self.counters.samples += len(ticks)
        self._last_layout = reader.name
        return self._block(reader.name, ticks, counts, frames["status"].copy(), self._axis.take_gaps())

    def _block(
        self,
        layout: str,
        ticks: NDArray[np.int64],
        counts: dict[str, NDArray[np.int16] | NDArray[np.uint16]],
        status: NDArray[np.uint16],
        gaps: tuple[Gap, ...],
    ) -> SampleBlock:
        return SampleBlock(
            layout=layout, divisor=self._axis.divisor, ticks=ticks, counts=counts, status=status, gaps=gaps
        )

    def _heed_reply(self, body: bytes) -> None:
        if body == LINK_LOST:
            self._axis.break_off(GapCause.RECONNECT)
            return
        try:
            _, reply = decode_message(body)
        except FrameError:
            return  # the link has counted it
        match reply:
            case StreamConfigReply(status=StatusCode.OK | StatusCode.CLAMPED, divisor=divisor) if divisor:
                self._axis.divisor = divisor
            case StreamStartReply(status=StatusCode.OK, tick=tick):
                self._axis.start(tick)
            case StreamStopReply(status=StatusCode.OK, tick=tick):
                self._axis.stop(tick)
            case HelloReply(status=StatusCode.OK, session=session):
                same = self._session in (None, session)
                self._axis.break_off(GapCause.RECONNECT if same else GapCause.REBOOT)
                self._session = session


@cache
def _frame_dtype(batch: int, channels: int) -> np.dtype[np.void]:
    """Structure of a stream message with `batch` samples of `channels` words."""
    return np.dtype(
        [
            ("type", "u1"),
            ("seq", "u1"),
            ("layout", "u1"),
            ("batch", "u1"),
            ("tick0", "<u4"),
            ("status", "<u2"),
            ("words", "<i2", (batch, channels)),
        ]
    )


def _runs(bodies: Sequence[bytes]) -> Iterator[Sequence[bytes]]:
    """Cut messages into runs that can be read together: stream frames of one shape, or replies."""
    if bodies and len(set(map(len, bodies))) == 1 and len({(b[0], b[2:4]) for b in bodies}) == 1:
        if bodies[0][0] in STREAM_TYPES or bodies[0] == LINK_LOST:
            yield bodies
        return
    for shape, run in groupby(bodies, key=lambda body: (body[0], len(body), body[2:4])):
        if shape[0] in STREAM_TYPES or shape[0] == LINK_LOST[0]:
            yield list(run)
