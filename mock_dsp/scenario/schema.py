"""Scenario files: what the emulator is to be. Read once, validated here, frozen afterwards."""

from pathlib import Path
from typing import Annotated, Self

import yaml
from pydantic import Field, ValidationError, model_validator

from mock_dsp.scenario.effects import EFFECTS, EffectParameter
from mock_dsp.scenario.faults import FAULTS, FaultName
from mock_dsp.scenario.rig_constants import RigConstants, Strict

MAX_SEED = 2**63 - 1
_FAULT_KEYS = ("at_s", "duration_s", "rate", "magnitude")


class ScenarioError(ValueError):
    """A scenario file is wrong; the message names file, field, value and what is allowed."""


class Effect(Strict):
    """One hidden effect: an id of the table `EFFECTS` and those of its numbers that are not the default.

    Attributes:
        id: Key of `EFFECTS`.
        parameters: Numbers as given.
    """

    id: str
    parameters: dict[str, float] = {}

    @model_validator(mode="after")
    def _check_parameters(self) -> Self:
        spec = EFFECTS.get(self.id)
        if spec is None:
            raise ValueError(f"effect id {self.id!r} is unknown; known: {', '.join(EFFECTS)}")
        known = {parameter.name: parameter for parameter in spec.parameters}
        for name, value in self.parameters.items():
            if name not in known:
                allowed = ", ".join(known) or "none"
                raise ValueError(f"effect {self.id} has no parameter {name!r}; it takes: {allowed}")
            _check_range(self.id, known[name], value)
        return self

    @property
    def complete_parameters(self) -> dict[str, float]:
        """All numbers of the effect, defaults included."""
        defaults = {parameter.name: parameter.default for parameter in EFFECTS[self.id].parameters}
        return defaults | self.parameters


class Fault(Strict):
    """One seeded fault; `mock_dsp.scenario.faults.FAULTS` says which keys each name takes.

    Attributes:
        name: Which fault.
        at_s: When it starts, s of device time; None for from the start.
        duration_s: How long it lasts, s; None for to the end (or the fault's own length).
        rate: Probability for each octet on the wire, 1.
        magnitude: Size, in the unit that `FAULTS` gives.
        seed: Seed of the fault's own random numbers.
    """

    name: FaultName
    at_s: Annotated[float, Field(ge=0.0, le=1e6)] | None = None
    duration_s: Annotated[float, Field(gt=0.0, le=1e6)] | None = None
    rate: Annotated[float, Field(ge=0.0, le=1.0)] | None = None
    magnitude: Annotated[float, Field(ge=-1e9, le=1e9)] | None = None
    seed: Annotated[int, Field(ge=0, le=MAX_SEED)] = 0

    @model_validator(mode="after")
    def _check_keys(self) -> Self:
        kind = FAULTS[self.name]
        given = [key for key in _FAULT_KEYS if getattr(self, key) is not None]
        missing = [key for key in kind.needs if key not in given]
        if missing:
            raise ValueError(f"fault {self.name.value} needs {', '.join(missing)}")
        surplus = [key for key in given if key not in kind.needs + kind.takes]
        if surplus:
            allowed = ", ".join(kind.needs + kind.takes) or "nothing"
            raise ValueError(
                f"fault {self.name.value} does not take {', '.join(surplus)}; it takes: {allowed}"
            )
        return self


class Scenario(Strict):
    """One emulated rig with its hidden effects and faults.

    `effects` is left out of `repr`, so that a sealed scenario is not given away by a log line.

    Attributes:
        name: Shown to the operator; says nothing about effects when sealed.
        seed: Seed of the sensor noise.
        rig: Physical constants; anything left out is the documented rig.
        effects: Hidden effects, any combination, each id at most once.
        faults: Seeded faults.
        sealed: Whether the effects were drawn and must not be shown.
    """

    name: Annotated[str, Field(min_length=1, max_length=80)]
    seed: Annotated[int, Field(ge=0, le=MAX_SEED)] = 1
    rig: RigConstants = RigConstants()
    effects: Annotated[tuple[Effect, ...], Field(repr=False)] = ()
    faults: tuple[Fault, ...] = ()
    sealed: bool = False

    @model_validator(mode="after")
    def _check_unique(self) -> Self:
        ids = [effect.id for effect in self.effects]
        doubled = sorted({effect_id for effect_id in ids if ids.count(effect_id) > 1})
        if doubled:
            raise ValueError(f"effect {', '.join(doubled)} stands twice; give each effect once")
        return self


def read_scenario(path: Path) -> Scenario:
    """Read and validate a scenario file.

    Raises:
        ScenarioError: The file is missing, is not YAML, or a field is wrong.
    """
    try:
        raw = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ScenarioError(f"{path}: {error.strerror}; see config/scenarios/") from error
    except (UnicodeDecodeError, yaml.YAMLError) as error:
        raise ScenarioError(f"{path}: {error}") from error
    if not isinstance(raw, dict):
        raise ScenarioError(f"{path}: expected a mapping with the keys {', '.join(Scenario.model_fields)}")
    try:
        return Scenario.model_validate(raw)
    except ValidationError as error:
        raise ScenarioError(f"{path}: {_first_problem(error)}") from error


def _first_problem(error: ValidationError) -> str:
    problem = error.errors(include_url=False)[0]
    field = ".".join(str(part) for part in problem["loc"]) or "scenario"
    value = problem["input"]
    shown = "" if isinstance(value, dict) else f" (value {value!r})"
    return f"{field}{shown}: {problem['msg'].removeprefix('Value error, ')}"


def _check_range(effect_id: str, parameter: EffectParameter, value: float) -> None:
    if not parameter.minimum <= value <= parameter.maximum:
        raise ValueError(
            f"effect {effect_id}: {parameter.name}={value} must lie in "
            f"[{parameter.minimum}, {parameter.maximum}] {parameter.unit}"
        )
