"""What a picture of an effect holds; how it looks stands in `svg.py`."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class Look(Enum):
    """What a line stands for."""

    WITHOUT = "the joint without the effect"
    FIRST = "the effect"
    SECOND = "the effect in another case"
    THIRD = "the effect in a third case"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Line:
    """One curve; `x` and `y` have shape (n,) and the units of their panel. Without a name it is not in the legend."""

    x: FloatArray
    y: FloatArray
    name: str = ""
    look: Look = Look.FIRST


@dataclass(frozen=True, slots=True, kw_only=True)
class Note:
    """A few words at a point of a panel, in its units; `align` is the side of the point on which they end."""

    x: float
    y: float
    text: str
    align: str = "left"


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """One pair of axes.

    Attributes:
        x, y: names of the axes with their units.
        levels, places: horizontal and vertical guides, at a parameter's value.
        logarithmic: both axes.
    """

    x: str
    y: str
    lines: tuple[Line, ...]
    notes: tuple[Note, ...] = ()
    levels: tuple[float, ...] = ()
    places: tuple[float, ...] = ()
    logarithmic: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """What is drawn of one effect.

    Attributes:
        title: one line that says what is to be seen.
        values: the parameters that it is drawn with, SI; a further value of one of them is named in the legend.
    """

    title: str
    panels: tuple[Panel, ...]
    values: Mapping[str, float] = field(default_factory=dict)
