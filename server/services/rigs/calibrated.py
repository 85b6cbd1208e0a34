"""A rig's channels in SI: which column each channel fills, with which scale; the rig file's calibration included."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from daq.calibration.channels import ChannelCalibration, calibrate_channels, counts_to_si
from daq.driver.capture import CapturePlan
from daq.driver.rig import Rig as DriverRig
from daq.protocol.codes import Trigger
from daq.protocol.dictionary import Dictionary
from server.config.rig import Rig
from server.services.errors import InvalidValueError
from server.services.rig_access import measured_calibration
from server.services.rigs.views import CaptureRequest

_WORD = {"i16": (-32768, 32767), "u16": (0, 65535)}


def channel_columns(driver: DriverRig, rig: Rig) -> dict[str, ChannelCalibration]:
    """Return each channel's calibration by the channel's name, as recordings of this rig use it."""
    calibrations = calibrate_channels(driver.dictionary.channels, measured_calibration(driver, rig))
    return {calibration.channel: calibration for calibration in calibrations}


def to_columns(
    counts: Mapping[str, NDArray[np.int16] | NDArray[np.uint16]],
    calibrations: Mapping[str, ChannelCalibration],
) -> dict[str, NDArray[np.float64]]:
    """Return raw words as SI columns, each of shape (n,), by column name."""
    return {
        calibrations[name].column: counts_to_si(words, calibrations[name]) for name, words in counts.items()
    }


def capture_plan(
    request: CaptureRequest, dictionary: Dictionary, calibrations: Mapping[str, ChannelCalibration]
) -> CapturePlan:
    """Return the driver's plan, its level in counts.

    Raises:
        InvalidValueError: no such layout, column or trigger.
    """
    layouts = {layout.name: layout for layout in dictionary.layouts}
    if request.layout not in layouts:
        raise _not_among("layout", request.layout, list(layouts))
    triggers = {trigger.name.lower(): trigger for trigger in Trigger}
    if request.trigger not in triggers:
        raise _not_among("trigger", request.trigger, list(triggers))
    trigger, channel, level = triggers[request.trigger], "", 0
    if trigger is Trigger.LEVEL:
        columns = {calibrations[name].column: name for name in layouts[request.layout].channels}
        if request.column not in columns:
            raise _not_among("column", request.column, list(columns))
        channel = columns[request.column]
        level = _level_counts(request.level, calibrations[channel], dictionary.channel(channel).type.value)
    return CapturePlan(
        layout=request.layout,
        trigger=trigger,
        decimation=request.decimation,
        pretrigger_percent=request.pretrigger_percent,
        channel=channel,
        level_counts=level,
    )


def _level_counts(level: float, calibration: ChannelCalibration, word: str) -> int:
    counts, (low, high) = round(level / calibration.scale + calibration.offset_counts), _WORD[word]
    if not low <= counts <= high:
        bounds = [(limit - calibration.offset_counts) * calibration.scale for limit in (low, high)]
        raise InvalidValueError(
            f"level={level:g} {calibration.unit} can never be measured",
            field="level",
            value=level,
            remedy=f"give a value in [{bounds[0]:g}, {bounds[1]:g}] {calibration.unit}",
        )
    return counts


def _not_among(field: str, value: str, known: list[str]) -> InvalidValueError:
    return InvalidValueError(
        f"there is no {field} {value!r} here",
        field=field,
        value=value,
        remedy=f"use one of {', '.join(known)}",
    )
