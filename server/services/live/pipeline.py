"""From raw samples as they come to input and output at the identification's sample time.

The way is that of `server/services/dataset.py`: speed from position without delay, the input averaged over the
interval ahead (`average_input`), both through the anti-alias filter; here in windows on a fixed grid (`hops.py`). Only
samples of the excitation count, and a hole begins a new segment. What the filters look ahead is the delay of the
estimates (`lookahead_s`), some 15 sample times.
"""

import copy
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from daq.calibration.channels import ChannelCalibration, counts_to_si
from daq.protocol.stream import SampleBlock
from daq.recording.derived_speed import SPEED_OF
from daq.recording.recording import recording_from_columns
from daq.recording.resample import design_antialias, extend_ends
from daq.speed.filters import speed_from_position_zero_phase
from server.services.dataset import INPUT_CHOICES, average_input
from server.services.live.hops import HopWindow, Matrix

_SPEED_HOP_S = 0.1
_SPEED_MARGIN_S = 0.6  # the speed filter's response to a sample has vanished, below rounding
_HOP_S = 0.05
Counts = Mapping[str, NDArray[np.int16] | NDArray[np.uint16]]


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveSource:
    """Where samples come from.

    Attributes:
        input: calibration of the channel that is the input.
        position: calibration of the channel whose speed is the output.
        tick_hz: controller ticks in a second.
        divisor: ticks from sample to sample.
        duration_s: length of the excitation.
    """

    input: ChannelCalibration
    position: ChannelCalibration
    tick_hz: float
    divisor: int
    duration_s: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rows:
    """Some rows of the estimators' data.

    Attributes:
        u, y: input and output, shape (n,).
        begins: whether the first one begins a segment.
        time_s: of the newest row, from the excitation's first tick.
    """

    u: NDArray[np.float64]
    y: NDArray[np.float64]
    begins: bool
    time_s: float


def choose_source(
    calibrations: Mapping[str, ChannelCalibration], *, tick_hz: float, divisor: int, duration_s: float
) -> LiveSource | None:
    """Return the source as an identification would choose it; None if there is no such input or position.

    Args:
        calibrations: of the channels that are recorded, by column.
        tick_hz: controller ticks in a second.
        divisor: ticks from sample to sample.
        duration_s: length of the excitation.
    """
    inputs = [calibrations[name] for name in INPUT_CHOICES if name in calibrations]
    positions = [calibrations[name] for name in SPEED_OF if name in calibrations]
    if not inputs or not positions:
        return None
    return LiveSource(
        input=inputs[0], position=positions[0], tick_hz=tick_hz, divisor=divisor, duration_s=duration_s
    )


class LivePipeline:
    """Makes rows of samples, in the order in which they come.

    Args:
        source: what the samples are.
        start_tick: of the excitation's first value.
        sample_time_s: of the rows; a multiple of the samples'.
    """

    def __init__(self, source: LiveSource, start_tick: int, sample_time_s: float) -> None:
        self._source = source
        self._own_s = source.divisor / source.tick_hz
        self._factor = max(1, round(sample_time_s / self._own_s))
        self._start_tick = start_tick
        self._stop_tick = start_tick + round(source.duration_s * source.tick_hz)
        self._next_tick: int | None = None
        self._segment_s = 0.0
        self._rows_of_segment = 0
        self._speed, self._decimation = self._new_stages()

    @property
    def sample_time_s(self) -> float:
        """Time between rows."""
        return self._factor * self._own_s

    @property
    def lookahead_s(self) -> float:
        """How long after a row the samples come that it needs."""
        return _SPEED_MARGIN_S + _SPEED_HOP_S + (self._margin + self._hop) * self._own_s

    @property
    def newest_tick(self) -> int:
        """Tick of the newest sample taken; -1 before the first."""
        return -1 if self._next_tick is None else self._next_tick - self._source.divisor

    @property
    def newest_s(self) -> float:
        """Time of the newest sample taken, from the excitation's first tick."""
        return (self.newest_tick - self._start_tick) / self._source.tick_hz

    def feed(self, block: SampleBlock) -> list[Rows]:
        """Take a block and return the rows that it completes."""
        margin = round(_SPEED_MARGIN_S * self._source.tick_hz)
        first = max(self._start_tick - margin, self.newest_tick + 1)
        keep = (block.ticks >= first) & (block.ticks < self._stop_tick + margin)
        ticks, rows = block.ticks[keep], list[Rows]()
        if not ticks.size:
            return rows
        samples = self._samples(block, keep)
        breaks = np.flatnonzero(np.diff(ticks) != self._source.divisor) + 1
        for piece, place in zip(np.split(samples, breaks), np.split(ticks, breaks), strict=True):
            if self._next_tick is not None and int(place[0]) != self._next_tick:
                rows += self.finish()
                self._speed, self._decimation = self._new_stages()
                self._rows_of_segment = 0
            self._next_tick = int(place[-1]) + self._source.divisor
            for moved in self._speed.push(piece):
                rows += self._decimated(moved)
        return rows

    def finish(self) -> list[Rows]:
        """Return the rows that are left when no further sample comes, or the next one is behind a hole."""
        rows = [row for moved in self._speed.flush() for row in self._decimated(moved)]
        return rows + [self._rows(result) for result in self._decimation.flush()]

    def look_ahead(self) -> list[Rows]:
        """Return the rows that would still come if the record ended with the newest sample; nothing changes.

        They are those that the filters' look-ahead holds back. Where it is missing, the filters continue the signal
        as at the end of a record, so that these rows are noisier than the final ones, the newest most.
        """
        ahead = copy.copy(self)
        ahead._speed, ahead._decimation = copy.copy(self._speed), copy.copy(self._decimation)
        return ahead.finish()

    def _samples(self, block: SampleBlock, keep: NDArray[np.bool_]) -> Matrix:
        """Return position, input and ticks from the excitation's first one, as columns."""
        channels = (self._source.position, self._source.input)
        columns = [counts_to_si(block.counts[each.channel][keep], each) for each in channels]
        return np.column_stack([*columns, (block.ticks[keep] - self._start_tick).astype(np.float64)])

    def _decimated(self, moved: Matrix) -> list[Rows]:
        """Cut speed, input and ticks to the excitation, and decimate; the speed alone has seen what is around it."""
        ticks = moved[:, 2]
        inside = moved[(ticks >= 0) & (ticks < self._stop_tick - self._start_tick)]
        if inside.size and not self._rows_of_segment and not self._decimation.begun:
            self._segment_s = float(inside[0, 2]) / self._source.tick_hz
        return [self._rows(result) for result in self._decimation.push(inside[:, :2])]

    @property
    def _margin(self) -> int:
        factor = self._factor
        half = len(design_antialias(factor)) // 2
        return 0 if factor == 1 else factor * (math.ceil(half / factor) + 2)

    @property
    def _hop(self) -> int:
        return self._factor * math.ceil(_HOP_S / self.sample_time_s)

    def _new_stages(self) -> tuple[HopWindow, HopWindow]:
        hop, margin = (max(1, round(each / self._own_s)) for each in (_SPEED_HOP_S, _SPEED_MARGIN_S))
        return (
            HopWindow(width=3, hop=hop, margin=margin, work=self._derive_speed),
            HopWindow(width=2, hop=self._hop, margin=self._margin, work=self._decimate),
        )

    def _derive_speed(self, window: Matrix, first: int, stop: int) -> Matrix:
        """Replace the position, column 0, by its speed."""
        speed = speed_from_position_zero_phase(window[:, 0], self._own_s)
        return np.column_stack([speed[first:stop], window[first:stop, 1:]])

    def _decimate(self, window: Matrix, first: int, stop: int) -> Matrix:
        """Average the input, column 1, over the interval ahead, and decimate both."""
        factor = self._factor
        if factor == 1:
            return window[first:stop]
        recording = recording_from_columns(
            {"time_s": np.arange(len(window)) * self._own_s, "input_A": window[:, 1]},
            sample_time_s=self._own_s,
        )
        u = average_input(recording, "input_A", self.sample_time_s).column("input_A")
        kept = range(first // factor, math.ceil(stop / factor))
        return np.column_stack([_decimate_rows(values, factor, kept) for values in (window[:, 0], u)])

    def _rows(self, result: Matrix) -> Rows:
        begins, self._rows_of_segment = self._rows_of_segment == 0, self._rows_of_segment + len(result)
        time_s = self._segment_s + (self._rows_of_segment - 1) * self.sample_time_s
        return Rows(u=result[:, 1].copy(), y=result[:, 0].copy(), begins=begins, time_s=time_s)


def _decimate_rows(values: NDArray[np.float64], factor: int, rows: range) -> NDArray[np.float64]:
    """Return some rows of `decimate(values, factor)`.

    Sums instead of a matrix product: their order depends on nothing but the number of taps, and no BLAS starts threads
    while samples come.
    """
    taps = design_antialias(factor)
    extended = extend_ends(values, len(taps) // 2, fitted=max(1, factor // 2))
    firsts = [row * factor for row in rows]
    return np.array([np.sum(extended[first : first + len(taps)] * taps) for first in firsts])
