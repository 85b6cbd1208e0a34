"""Which numbers of the joint a fit moves, in which scaled coordinates, and where it starts."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Ranges, Start
from discrepancy.effects.table import EFFECTS
from discrepancy.model.schema import BASE_SLOTS, JointModel
from discrepancy.simulation import slots as s

FloatArray = NDArray[np.float64]

BASE = "base"
TIMING = "input_timing"
SMOOTHING = "speed_smoothing"
SMOOTHING_RANGE_S = (1e-4, 0.035)
"""Time constants of the zero-phase smoothing of a speed column; the longest is a corner of 4.5 Hz."""
SMOOTHING_START_S = 0.008
NUISANCES = frozenset({TIMING, SMOOTHING})
"""What a recording's making leaves open; fitted, but no part of the joint."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FitParameter:
    """A number that a fit moves.

    Attributes:
        owner: `base` or an effect's id.
        scale: size of a typical change; of the logarithm where `logarithmic`.
    """

    owner: str
    name: str
    slot: int
    lower: float
    upper: float
    scale: float
    logarithmic: bool = False

    def encode(self, value: float) -> float:
        """Return the scaled coordinate of a value."""
        return math.log(max(value, 1e-300)) if self.logarithmic else value / self.scale

    def decode(self, z: float) -> float:
        """Return the value at a scaled coordinate, inside the bounds."""
        value = math.exp(min(z, 690.0)) if self.logarithmic else z * self.scale
        return min(self.upper, max(self.lower, value))

    def slope(self, value: float) -> float:
        """Return d value / d coordinate."""
        return value if self.logarithmic else self.scale

    def known_before(self, value: float) -> float:
        """Return how well the coordinate of a value is known before any data, as an inverse variance: 0 for not at all.

        How a recording was made lies between two bounds, and nothing prefers a place between them (a rectangular
        distribution, JCGM 100:2008, 4.3.7); a fit that data do not lead may have ended anywhere in between, so the
        variance is taken about the value.
        """
        if self.name not in NUISANCES:
            return 0.0
        lower, upper = self.encode(self.lower), self.encode(self.upper)
        off = self.encode(value) - 0.5 * (lower + upper)
        return 1.0 / ((upper - lower) ** 2 / 12.0 + off**2)


def natural_size(kind: Kind, r: Ranges) -> float:
    """Return the size of a parameter of this kind that matters on these signals."""
    travel = max(r.high - r.low, 1e-9)
    return {
        Kind.TORQUE: r.torque,
        Kind.SPEED: r.speed,
        Kind.CURRENT: r.current,
        Kind.INPUT: r.current,
        Kind.TIME: 0.05,
        Kind.ANGLE: travel,
        Kind.WAVE: 1.0,
        Kind.RATIO: 1.0,
        Kind.VISCOUS: r.torque / r.speed,
        Kind.QUADRATIC: r.torque / r.speed**2,
        Kind.STIFFNESS: r.torque / travel,
    }[kind]


def fit_parameter(effect: Effect, parameter: EffectParameter, ranges: Ranges) -> FitParameter:
    """Return the fit's view of an effect's parameter."""
    owner = effect.id
    limits = effect.limits(ranges) if effect.limits is not None else {}
    lower, upper = limits.get(parameter.name, (parameter.lower, parameter.upper))
    return FitParameter(
        owner=owner,
        name=parameter.name,
        slot=parameter.slot,
        lower=lower,
        upper=upper,
        scale=1.0 if parameter.logarithmic else natural_size(parameter.kind, ranges),
        logarithmic=parameter.logarithmic,
    )


def base_parameters(
    model: JointModel, ranges: Ranges, timing: tuple[float, float] | None
) -> list[FitParameter]:
    """Return the nameplate parameters that are not fixed, and the input's timing if it is unknown."""
    found = []
    for name, quantity in model.parameters.items():
        if quantity.fixed:
            continue
        slot = BASE_SLOTS[name]
        positive = slot != s.VISCOUS
        scale = abs(quantity.value) or ranges.torque / ranges.speed
        found.append(
            FitParameter(
                owner=BASE, name=name, slot=slot, lower=1e-12 if positive else 0.0, upper=math.inf,
                scale=1.0 if positive else scale, logarithmic=positive,
            )
        )  # fmt: skip
    if timing is not None:
        found.append(
            FitParameter(
                owner=BASE, name=TIMING, slot=s.INPUT_SHIFT, lower=timing[0], upper=timing[1],
                scale=max(timing[1] - timing[0], 1e-9),
            )
        )  # fmt: skip
    return found


def smoothing_parameter() -> FitParameter:
    """Return the unknown smoothing of a speed column."""
    lower, upper = SMOOTHING_RANGE_S
    return FitParameter(
        owner=BASE, name=SMOOTHING, slot=s.OUTPUT_SMOOTHING, lower=lower, upper=upper, scale=1.0,
        logarithmic=True,
    )  # fmt: skip


def effect_parameters(effect: Effect, present: Sequence[str], ranges: Ranges) -> list[FitParameter]:
    """Return the effect's free parameters, without those that an effect already present supplies."""
    dropped = {name for name, owners in effect.shared.items() if set(owners) & set(present)}
    return [
        fit_parameter(effect, parameter, ranges)
        for parameter in effect.parameters
        if parameter.free and parameter.name not in dropped
    ]


def write_start(vector: FloatArray, effect: Effect, start: Start, present: Sequence[str]) -> FloatArray:
    """Return the vector with an effect's starting values."""
    dropped = {name for name, owners in effect.shared.items() if set(owners) & set(present)}
    changed = vector.copy()
    for parameter in effect.parameters:
        if parameter.name in dropped:
            changed[parameter.slot] = s.neutral_vector()[parameter.slot]
        elif parameter.name in start:
            changed[parameter.slot] = start[parameter.name]
    return changed


def clear_effect(vector: FloatArray, effect: Effect) -> FloatArray:
    """Return the vector with an effect switched off."""
    changed = vector.copy()
    neutral = s.neutral_vector()
    for parameter in effect.parameters:
        changed[parameter.slot] = neutral[parameter.slot]
    return changed


def model_vector(model: JointModel) -> FloatArray:
    """Return the kernel's vector for a model at its nameplate values."""
    vector = s.neutral_vector()
    for name, quantity in model.parameters.items():
        vector[BASE_SLOTS[name]] = quantity.value
    for term in model.effects:
        slots: Mapping[str, int] = {p.name: p.slot for p in EFFECTS[term.id].parameters}
        for name, quantity in term.parameters.items():
            vector[slots[name]] = quantity.value
    vector[s.INPUT_IS_MEASURED] = 0.0 if model.input == "current_ref_A" else 1.0
    return vector
