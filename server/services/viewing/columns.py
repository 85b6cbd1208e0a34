"""SI columns of a rig's live samples: channels by the calibration of recordings, and the speed from the position.

All viewers of a rig share one `LiveColumns`, so that a block is converted once and not once for each of them.
"""

import threading
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from daq.calibration.channels import ChannelCalibration, counts_to_si
from daq.driver.options import StreamPlan
from daq.driver.rig import Rig as DriverRig
from daq.protocol.stream import SampleBlock
from daq.recording.derived_speed import SPEED_OF
from daq.speed.filters import CausalSpeedFilter
from server.config.rig import Rig
from server.services.errors import InvalidValueError
from server.services.rigs.calibrated import channel_columns
from server.services.rigs.served_rig import ServedRig

Floats = NDArray[np.float64]
_KEPT_BLOCKS = 128  # more than wait in a viewer's queue
_POSITION_OF = {speed: position for position, speed in SPEED_OF.items()}


@dataclass(slots=True)
class _Converted:
    """A block with what was made of it; the block itself is kept, so that its identity stays its own."""

    block: SampleBlock
    columns: dict[str, Floats | None] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class _Speed:
    """A causal filter as it stands behind a sample."""

    filter: CausalSpeedFilter
    state: Floats
    divisor: int
    next_tick: int


class LiveColumns:
    """What columns one connection of a rig can give, and how they are made of counts.

    Args:
        driver: the open rig.
        rig: its file, for its calibration.
    """

    def __init__(self, driver: DriverRig, rig: Rig) -> None:
        self.driver = driver
        self.tick_hz = driver.hello.tick_hz
        by_channel = channel_columns(driver, rig)
        self._calibrations: Mapping[str, ChannelCalibration] = {
            calibration.column: calibration for calibration in by_channel.values()
        }
        layouts = {layout.name: layout.channels for layout in driver.dictionary.layouts}
        usual = [by_channel[name].column for name in layouts.get(StreamPlan().layout, ())]
        derived = [speed for speed, position in _POSITION_OF.items() if position in self._calibrations]
        self._units = {name: each.unit for name, each in self._calibrations.items()}
        for speed in derived:
            self._units.setdefault(speed, self._units[_POSITION_OF[speed]] + "/s")
        self._speeds: dict[str, _Speed] = {}
        self._converted: OrderedDict[int, _Converted] = OrderedDict()
        self.default = (*usual, *(speed for speed in derived if speed not in usual))

    def choose(self, wanted: tuple[str, ...]) -> tuple[str, ...]:
        """Return the columns wanted, or the usual ones for none.

        Raises:
            InvalidValueError: one that this controller does not have.
        """
        for name in wanted:
            if name not in self._units:
                raise InvalidValueError(
                    f"this rig has no column {name!r}",
                    field="columns",
                    value=name,
                    remedy=f"use some of {', '.join(self._units)}",
                )
        return wanted or self.default

    def unit(self, column: str) -> str:
        """Return a column's unit."""
        return self._units[column]

    def convert(self, block: SampleBlock, column: str) -> Floats | None:
        """Return one column of a block in SI, None when the stream does not carry it.

        Only the event loop's thread calls it.
        """
        kept = self._converted.get(id(block))
        if kept is None:
            kept = self._converted[id(block)] = _Converted(block)
            if len(self._converted) > _KEPT_BLOCKS:
                self._converted.popitem(last=False)
        if column not in kept.columns:
            kept.columns[column] = self._make(block, column)
        return kept.columns[column]

    def _make(self, block: SampleBlock, column: str) -> Floats | None:
        calibration = self._calibrations.get(column)
        counts = None if calibration is None else block.counts.get(calibration.channel)
        if calibration is not None and counts is not None:
            return counts_to_si(counts, calibration)
        position = self.convert(block, _POSITION_OF[column]) if column in _POSITION_OF else None
        if position is None or not len(block.ticks):
            return None
        # A viewer far behind asks for a block that was forgotten: the others' filter must not go back for it.
        behind = column in self._speeds and int(block.ticks[0]) < self._speeds[column].next_tick
        carried = None if behind else self._speeds.get(column)
        made, after = derive(block, position, carried, self.tick_hz)
        if not behind and after is not None:
            self._speeds[column] = after
        return made


def derive(
    block: SampleBlock, position: Floats, carried: _Speed | None, tick_hz: int
) -> tuple[Floats, _Speed | None]:
    """Return the speed of a block's samples, and the filter behind them; it starts anew behind each hole.

    Args:
        block: for its ticks; at least one sample.
        position: its position, shape (n,).
        carried: the filter behind the block before it, None for a start.
        tick_hz: controller ticks per second.
    """
    speed = np.empty_like(position)
    for part in runs_of(block):
        first, after = int(block.ticks[part.start]), int(block.ticks[part.stop - 1]) + block.divisor
        if carried is None or carried.next_tick != first or carried.divisor != block.divisor:
            fresh = CausalSpeedFilter(block.divisor / tick_hz)
            carried = _Speed(fresh, fresh.init(), block.divisor, first)
        speed[part] = carried.filter.step(carried.state, position[part])
        carried = _Speed(carried.filter, carried.state, block.divisor, after)
    return speed, carried


def runs_of(block: SampleBlock) -> list[slice]:
    """Return the parts of a block without a hole inside."""
    ticks, size = block.ticks, len(block.ticks)
    if not size:
        return []
    if int(ticks[-1]) - int(ticks[0]) == (size - 1) * block.divisor:  # the usual case: ticks only rise
        return [slice(0, size)]
    breaks = np.flatnonzero(np.diff(ticks) != block.divisor) + 1
    edges = [0, *breaks.tolist(), size]
    return [slice(start, end) for start, end in zip(edges[:-1], edges[1:], strict=True)]


class LiveSources:
    """The columns of each rig as it is connected now."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._known: dict[str, LiveColumns] = {}

    def of(self, rig: ServedRig) -> LiveColumns:
        """Return the columns that all viewers of a rig share.

        Raises:
            ConflictError: it is not connected.
        """
        driver = rig.worker.driver
        with self._lock:
            known = self._known.get(rig.id)
            if known is None or known.driver is not driver:
                known = self._known[rig.id] = LiveColumns(driver, rig.rig)
            return known
