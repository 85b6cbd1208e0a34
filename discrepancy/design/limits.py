"""What a proposed experiment may do to the rig: from a rig file, or from what the training records have shown safe."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from discrepancy.data.series import Series

Excitation = Mapping[str, Any]  # Any: values of a campaign's keys
Admits = Callable[[Excitation, float], bool]

LONGEST_S = 80.0


@dataclass(frozen=True, slots=True, kw_only=True)
class RigLimits:
    """What the rig allows.

    Attributes:
        amplitude: largest current, A (force inputs: N).
        travel_low, travel_high: ends of the travel from where the joint stands, rad (m).
        speed: largest speed, rad/s (m/s).
        jump: largest sudden change of the input, A (N).
        longest_s: longest record, s.
        admits: the rig's own check of an excitation and its duration, s; None where no rig is known.
    """

    amplitude: float
    travel_low: float = -math.inf
    travel_high: float = math.inf
    speed: float = math.inf
    jump: float = math.inf
    longest_s: float = LONGEST_S
    admits: Admits | None = None

    def allows(self, excitation: Excitation, duration_s: float) -> bool:
        """Return whether the rig itself would take this excitation."""
        return self.admits is None or self.admits(excitation, duration_s)


def limits_of_records(series: Sequence[Series]) -> RigLimits:
    """Return limits that the training records themselves have shown to be safe.

    A joint that has swung over a span may swing over the same span to either side of where it starts.
    """
    span = max((float(np.ptp(one.angle)) for one in series if one.angle.size), default=0.0)
    reach = span if span > 0.0 else math.inf
    return RigLimits(
        amplitude=max(float(np.max(np.abs(one.input))) for one in series),
        travel_low=-reach,
        travel_high=reach,
        jump=max(float(np.max(np.abs(np.diff(one.input)), initial=0.0)) for one in series),
    )
