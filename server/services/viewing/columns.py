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
    columns: dict[str, Floats] = field(default_factory=dict)


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
        calibration = self._calibrations.get(column)
        counts = None if calibration is None else block.counts.get(calibration.channel)
        if calibration is None or counts is None:
            return None
        kept = self._converted.get(id(block))
        if kept is None:
            kept = self._converted[id(block)] = _Converted(block)
            if len(self._converted) > _KEPT_BLOCKS:
                self._converted.popitem(last=False)
        if column not in kept.columns:
            kept.columns[column] = counts_to_si(counts, calibration)
        return kept.columns[column]

    def position_of(self, speed: str) -> str:
        """Return the position column that a speed is made of; empty for anything else."""
        return _POSITION_OF.get(speed, "")


class LiveSpeed:
    """The speed of one viewer, carried from block to block and begun anew behind each hole.

    Args:
        sample_time_s: time between samples.
    """

    def __init__(self, sample_time_s: float) -> None:
        self._filter = CausalSpeedFilter(sample_time_s)
        self._state = self._filter.init()

    def step(self, position: Floats) -> Floats:
        """Return the speed of the next samples, shape (n,)."""
        return self._filter.step(self._state, position)


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
