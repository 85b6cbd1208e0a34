"""What one viewer sees of a rig: its choice of columns and rate, and the frames made of the blocks that come.

Theory of operation. A view belongs to one viewer and is fed with what its own queue held; nothing here is shared, so
the viewer's choices cost nobody else anything. Samples that follow each other without a hole make one run; whenever
ticks jump (a loss on the line, blocks that this viewer's queue dropped, a new stream), the run ends, a bucket that
was not yet full is sent as it is, and the next frame carries the BREAK flag.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from daq.protocol.stream import SampleBlock
from server.services.errors import InvalidValueError
from server.services.rigs.served_rig import ServedRig
from server.services.viewing.clock import wall_clock_ns
from server.services.viewing.columns import LiveSources, runs_of
from server.services.viewing.decimation import min_max_rows
from server.services.viewing.frame import FrameFlag, LiveFrame, encode_live

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveOptions:
    """What a viewer wants.

    Attributes:
        columns: in this order; none for the usual ones.
        rate_hz: rows per second, made by min/max decimation; None for every sample.
        interval_ms: a frame at most so often.
    """

    columns: tuple[str, ...] = ()
    rate_hz: float | None = None
    interval_ms: int = 50


@dataclass(slots=True, kw_only=True)
class _Run:
    """Samples without a hole that still wait to be sent.

    Attributes:
        first_tick: of the first of them.
        divisor: ticks per sample.
        begins: whether a hole, or nothing, lies before it.
        parts: SI values, each of shape (columns, n).
    """

    first_tick: int
    divisor: int
    begins: bool
    parts: list[Floats]

    @property
    def size(self) -> int:
        return sum(part.shape[1] for part in self.parts)

    @property
    def next_tick(self) -> int:
        return self.first_tick + self.size * self.divisor


class LiveView:
    """Turns one viewer's blocks into its frames.

    Args:
        rig: what is watched; it must be connected when the view is made.
        sources: where all viewers' columns come from.
        options: what the viewer wants.

    Raises:
        ConflictError: the rig is not connected.
        InvalidValueError: a column that it does not have, or too high a rate.
    """

    def __init__(self, rig: ServedRig, sources: LiveSources, options: LiveOptions) -> None:
        self._rig = rig
        self._sources = sources
        self._frames = 0
        self._lost = 0
        self.plan = -1
        self.options = options
        self._source = sources.of(rig)
        self._run: _Run | None = None
        self._ended: list[_Run] = []
        self.change(options)

    def change(self, options: LiveOptions) -> None:
        """Take other options from now on.

        Raises:
            InvalidValueError: what they ask for cannot be had; the old ones stay.
        """
        columns = self._source.choose(options.columns)
        if options.rate_hz is not None and options.rate_hz > self._source.tick_hz:
            raise InvalidValueError(
                f"rate_hz={options.rate_hz:g} is more than the controller measures",
                field="rate_hz",
                value=options.rate_hz,
                remedy=f"give at most {self._source.tick_hz}, or leave it out for every sample",
            )
        self.options, self._columns = options, columns
        self._run, self._ended = None, []
        self.plan += 1

    def describe(self) -> dict[str, object]:
        """Return the plan in force as JSON values: what each frame's columns are."""
        return {
            "type": "plan",
            "plan": self.plan,
            "rig": self._rig.id,
            "columns": [{"name": name, "unit": self._source.unit(name)} for name in self._columns],
            "rate_hz": self.options.rate_hz,
            "interval_ms": self.options.interval_ms,
            "tick_hz": self._source.tick_hz,
        }

    def frames(self, blocks: Sequence[SampleBlock], dropped: int) -> list[bytes]:
        """Return the frames that these blocks make.

        Args:
            blocks: what waited, oldest first.
            dropped: samples that the viewer's queue has dropped so far.
        """
        self._heed_reconnection()
        for block in blocks:
            self._lost += sum(gap.missing_samples for gap in block.gaps)
            self._add(block)
        made = [frame for run in self._ended for frame in self._send(run, dropped, rest=True)]
        self._ended.clear()
        if self._run is not None:
            made.extend(self._send(self._run, dropped, rest=False))
        return made

    def heartbeat(self, dropped: int) -> bytes:
        """Return a frame without rows, for times when nothing comes."""
        return self._encode(np.empty((0, 0), np.float32), FrameFlag(0), 1, 0, 0.0, dropped, None)

    def _heed_reconnection(self) -> None:
        driver = self._rig.worker.open_driver
        if driver is not None and driver is not self._source.driver:
            self._source, self._run = self._sources.of(self._rig), None

    def _add(self, block: SampleBlock) -> None:
        for part in runs_of(block):
            self._extend(block, part)

    def _extend(self, block: SampleBlock, part: slice) -> None:
        run, first = self._run, int(block.ticks[part.start])
        if run is None or run.next_tick != first or run.divisor != block.divisor:
            if run is not None:
                self._ended.append(run)
            run = _Run(first_tick=first, divisor=block.divisor, begins=True, parts=[])
            self._run = run
        values = np.empty((len(self._columns), part.stop - part.start))
        for row, name in enumerate(self._columns):
            found = self._source.convert(block, name)
            values[row] = np.nan if found is None else found[part]
        run.parts.append(values)

    def _send(self, run: _Run, dropped: int, *, rest: bool) -> Iterator[bytes]:
        """Give the frame of what waits in a run; `rest`: with the bucket that is not full, as no more comes."""
        sample_hz = self._source.tick_hz / run.divisor
        per_row = 1 if self.options.rate_hz is None else max(1, round(sample_hz / self.options.rate_hz))
        count = run.size if rest else run.size - run.size % per_row
        if not count:
            return
        samples = run.parts[0] if len(run.parts) == 1 else np.concatenate(run.parts, axis=1)
        ready, run.parts = samples[:, :count], [samples[:, count:]] if count < samples.shape[1] else []
        rows = min_max_rows(ready, per_row) if per_row > 1 else ready.astype(np.float32)
        flags = (FrameFlag.MIN_MAX if per_row > 1 else FrameFlag(0)) | (
            FrameFlag.BREAK if run.begins else FrameFlag(0)
        )
        first, newest = run.first_tick, run.first_tick + (count - 1) * run.divisor
        run.first_tick, run.begins = first + count * run.divisor, False
        yield self._encode(rows, flags, per_row, first, per_row / sample_hz, dropped, newest)

    def _encode(  # noqa: PLR0913  # the fields of a frame
        self,
        rows: NDArray[np.float32],
        flags: FrameFlag,
        per_row: int,
        first_tick: int,
        row_s: float,
        dropped: int,
        newest_tick: int | None,
    ) -> bytes:
        now_ns = time.time_ns()
        frame = LiveFrame(
            plan=self.plan,
            flags=flags,
            samples_per_row=per_row,
            first_tick=first_tick,
            row_s=row_s,
            dropped=dropped,
            lost=self._lost,
            newest_ns=0 if newest_tick is None else wall_clock_ns(self._source.driver, newest_tick, now_ns),
            sent_ns=now_ns,
            number=self._frames,
            values=rows,
        )
        self._frames += 1
        return encode_live(frame)
