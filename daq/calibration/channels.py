"""From counts to SI: SI value = (counts - offset) * scale, channel by channel.

The controller's dictionary brings nominal scales; a rig's own calibration (a measured Hall offset, a
potentiometer's true electrical angle) replaces them by name and says where it comes from. Counts never leave
this module's callers as anything but SI values; the recording keeps the counts themselves, so a calibration
found later can be applied again.
"""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from daq.errors import RecordingError
from daq.protocol.dictionary_entries import Channel

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelCalibration:
    """How one channel's counts become a column.

    Attributes:
        channel: name on the wire.
        column: name of the SI column.
        unit: unit of the column.
        scale: SI value of one count.
        offset_counts: counts at the SI value zero.
        source: where the numbers come from.
    """

    channel: str
    column: str
    unit: str
    scale: float
    offset_counts: float
    source: str

    def to_dict(self) -> dict[str, float | str]:
        """Return JSON values, for a recording's metadata."""
        return asdict(self)


def calibrate_channels(
    channels: Iterable[Channel], measured: Mapping[str, Mapping[str, Any]] | None = None
) -> tuple[ChannelCalibration, ...]:
    """Return the calibration of each channel: the rig's own where it has one, the dictionary's elsewhere.

    Args:
        channels: as the controller's dictionary describes them.
        measured: channel name -> any of `scale`, `offset_counts`, and the `source` of the numbers.

    Raises:
        RecordingError: a measured calibration names an unknown channel or field, or its numbers are unusable.
    """
    nominal = {
        channel.name: ChannelCalibration(
            channel=channel.name,
            column=channel.column,
            unit=channel.unit,
            scale=channel.scale,
            offset_counts=channel.offset,
            source="controller dictionary",
        )
        for channel in channels
    }
    for name, numbers in (measured or {}).items():
        if name not in nominal:
            raise RecordingError(
                f"calibration of unknown channel {name!r}; the stream has {', '.join(nominal)}"
            )
        nominal[name] = _replaced(nominal[name], numbers)
    return tuple(nominal.values())


def counts_to_si(counts: npt.NDArray[np.generic], calibration: ChannelCalibration) -> FloatArray:
    """Return the SI values of raw counts, shape unchanged."""
    values = counts.astype(np.float64)
    values -= calibration.offset_counts
    values *= calibration.scale
    return values


def _replaced(nominal: ChannelCalibration, numbers: Mapping[str, Any]) -> ChannelCalibration:
    unknown = set(numbers) - {"scale", "offset_counts", "source"}
    if unknown:
        raise RecordingError(
            f"calibration of {nominal.channel!r} has unknown fields {', '.join(sorted(unknown))}; "
            "known are scale, offset_counts, source"
        )
    scale = float(numbers.get("scale", nominal.scale))
    offset = float(numbers.get("offset_counts", nominal.offset_counts))
    if not (np.isfinite(scale) and scale != 0.0 and np.isfinite(offset)):
        raise RecordingError(
            f"calibration of {nominal.channel!r}: scale={scale} and offset_counts={offset} "
            "must be finite numbers, and the scale not 0"
        )
    return replace(nominal, scale=scale, offset_counts=offset, source=str(numbers.get("source", "rig")))
