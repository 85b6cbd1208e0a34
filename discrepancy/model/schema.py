"""The joint model in memory: nameplate parameters, effects already known, and how it is to be judged."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum

from discrepancy.effects.table import EFFECTS
from discrepancy.errors import ModelFileError
from discrepancy.simulation import slots as s


class Judge(Enum):
    """What the gap is measured on."""

    SIMULATION = "simulation"
    TORQUE = "torque"


class InputHold(Enum):
    """What the input does between two samples."""

    HOLD = "hold"
    LINEAR = "linear"
    AUTO = "auto"


BASE_SLOTS: Mapping[str, int] = {
    "inertia": s.INERTIA,
    "mass": s.INERTIA,
    "viscous_friction": s.VISCOUS,
    "torque_constant": s.TORQUE_CONSTANT,
    "force_constant": s.TORQUE_CONSTANT,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """A parameter's value with its unit; `std` is its standard error where it was estimated."""

    value: float
    unit: str = ""
    std: float | None = None
    fixed: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectTerm:
    """One effect in a model with the values of its parameters."""

    id: str
    parameters: Mapping[str, Quantity]


@dataclass(frozen=True, slots=True, kw_only=True)
class JointModel:
    """A joint as its model file describes it.

    Attributes:
        input: column that drives the simulation.
        outputs: columns to reproduce.
        parameters: nameplate values by name (`BASE_SLOTS`).
        lineage: one line per earlier version: name, what was added, from which records.
    """

    name: str
    axis: str
    input: str
    outputs: tuple[str, ...]
    parameters: Mapping[str, Quantity]
    effects: tuple[EffectTerm, ...] = ()
    judge_by: Judge = Judge.SIMULATION
    input_hold: InputHold = InputHold.AUTO
    version: int = 1
    lineage: tuple[Mapping[str, object], ...] = field(default_factory=tuple)

    def __post_init__(self) -> None:
        """Check names against the catalogue and the allowed parameters."""
        for name in self.parameters:
            if name not in BASE_SLOTS:
                raise ModelFileError(
                    f"parameters.{name}: unknown parameter; allowed are {', '.join(BASE_SLOTS)}"
                )
        if not {BASE_SLOTS[name] for name in self.parameters} & {s.INERTIA}:
            raise ModelFileError("parameters: inertia (or mass) is missing; give its nameplate value")
        for term in self.effects:
            if [one.id for one in self.effects].count(term.id) > 1:
                raise ModelFileError(f"effects: {term.id!r} stands twice; remove one of them")
            if term.id not in EFFECTS:
                raise ModelFileError(
                    f"effects: {term.id!r} is not in the catalogue; allowed: {', '.join(EFFECTS)}"
                )
            known = {parameter.name for parameter in EFFECTS[term.id].parameters}
            for name in term.parameters:
                if name not in known:
                    raise ModelFileError(
                        f"effects.{term.id}.{name}: unknown parameter; allowed: {', '.join(sorted(known))}"
                    )

    @property
    def is_linear_axis(self) -> bool:
        """Whether position is in m and torque in N."""
        return self.axis == "linear"

    def with_effects(self, effects: tuple[EffectTerm, ...]) -> "JointModel":
        """Return the same joint with other effects."""
        return replace(self, effects=effects)
