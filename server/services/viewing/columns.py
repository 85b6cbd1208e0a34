"""SI columns of a rig's live samples: channels by the calibration of recordings, and the speed from the position."""

from collections.abc import Mapping

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

Floats = NDArray[np.float64]
_POSITION_OF = {speed: position for position, speed in SPEED_OF.items()}


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

    def convert(self, block: SampleBlock, run: slice, column: str) -> Floats | None:
        """Return one column of a part of a block in SI, None when the stream does not carry it."""
        calibration = self._calibrations.get(column)
        counts = None if calibration is None else block.counts.get(calibration.channel)
        return None if calibration is None or counts is None else counts_to_si(counts[run], calibration)

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
