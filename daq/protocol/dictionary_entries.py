"""The entries of a controller's dictionary: parameters, channels, layouts, faults, generators, buffer sizes.

Records only; `dictionary.py` reads and writes them.
"""

from dataclasses import dataclass
from enum import Enum

import numpy as np


class CountType(Enum):
    """How a channel's 16-bit word is read."""

    I16 = "i16"
    U16 = "u16"

    @property
    def dtype(self) -> np.dtype[np.int16] | np.dtype[np.uint16]:
        """Little-endian numpy type of one word."""
        return np.dtype("<i2") if self is CountType.I16 else np.dtype("<u2")


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """A parameter: SI value = raw * scale; `minimum`, `maximum` and `default` are SI."""

    id: int
    name: str
    unit: str
    scale: float
    minimum: float
    maximum: float
    default: float
    writable: bool
    writable_armed: bool
    doc: str

    def to_raw(self, value_si: float) -> int:
        """Nearest raw value."""
        return round(value_si / self.scale)

    def to_si(self, raw: int) -> float:
        """SI value of a raw value."""
        return raw * self.scale


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """A sampled quantity: SI value = (counts - offset) * scale, recorded in the column `column`."""

    name: str
    column: str
    unit: str
    type: CountType
    scale: float
    offset: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """The channels of one sample, in the order in which their words are sent."""

    id: int
    name: str
    channels: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FaultText:
    """What a fault bit means and what to do about it."""

    bit: int
    name: str
    text: str
    remedy: str


@dataclass(frozen=True, slots=True, kw_only=True)
class GeneratorName:
    """An excitation that the controller can make."""

    id: int
    name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class SetpointBuffer:
    """Sizes of the set-point stream, in words."""

    half_words: int = 256
    halves: int = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class CaptureBuffer:
    """Size of the capture buffer, in words."""

    words: int = 4096


@dataclass(frozen=True, slots=True, kw_only=True)
class WaveSlots:
    """Size of the table slots, in words."""

    words: int = 1024
    slots: int = 2
