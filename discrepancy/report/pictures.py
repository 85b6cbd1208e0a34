"""What the report draws beside the curves over time: plain data, computed where the fitted model is at hand."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from discrepancy.locate import Place

FloatArray = NDArray[np.float64]

_EMPTY: FloatArray = np.empty(0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Binned:
    """Measured values, averaged over cells of the variable on the x axis.

    Attributes:
        x, mean: middle and mean of each cell, shape (m,).
        error: half the width of the mean's 95 % interval, shape (m,).
        count: samples in each cell, shape (m,).
    """

    x: FloatArray
    mean: FloatArray
    error: FloatArray
    count: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LawPicture:
    """A law over the variable that drives it, on top of what the model without it leaves.

    Attributes:
        x_name, y_name: axis titles without unit.
        law_x, law: the fitted law, shape (k,); empty where there is none.
        low, high: its 95 % band from the standard errors of its parameters, shape (k,); empty where not known.
    """

    x_name: str
    x_unit: str
    y_name: str
    y_unit: str
    points: Binned
    law_x: FloatArray = field(default_factory=lambda: _EMPTY)
    law: FloatArray = field(default_factory=lambda: _EMPTY)
    low: FloatArray = field(default_factory=lambda: _EMPTY)
    high: FloatArray = field(default_factory=lambda: _EMPTY)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Spectrum:
    """Amplitude density of a signal, unit / sqrt(Hz), one-sided, over the frequency in Hz; both of shape (m,)."""

    frequency: FloatArray
    density: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Detectable:
    """The smallest strength at which an effect would have been noticed in these records.

    Attributes:
        parameter: the one that was varied; the effect's others stood at their first starting values.
    """

    id: str
    parameter: str
    size: float
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Pictures:
    """What belongs to the whole answer, not to one step.

    Attributes:
        noise: measured noise of each output, from repeated records; empty without repeats.
        left: what the last model leaves, by place, largest share first.
        unknown: the part that has no name, over the variable that drives it.
        detectable: filled where nothing was named.
    """

    noise: Mapping[str, Spectrum] = field(default_factory=dict)
    left: tuple[Place, ...] = ()
    unknown: LawPicture | None = None
    detectable: tuple[Detectable, ...] = ()
