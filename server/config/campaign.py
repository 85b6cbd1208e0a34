"""The campaign file: which steps a rig plays by itself, checked as a whole before anything moves."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from server.config.excitation import Excitation
from server.config.model import STEP_TAG, StrictModel, suggest
from server.config.units import Seconds

# `speed_rad_s` may be missing in a recording: it is then derived from the position.
DEFAULT_OUTPUT = "speed_rad_s"
StepName = Annotated[str, Field(min_length=1, max_length=64, pattern=r"^[A-Za-z0-9_.-]+$")]


def _as_list(value: object) -> object:
    """Take a single name for a list of one."""
    return [value] if isinstance(value, str) else value


class RecordStep(StrictModel):
    """Play one excitation and record it."""

    step: Literal["record"]
    name: StepName
    excitation: Excitation
    duration_s: Annotated[Seconds, Field(gt=0, le=86_400)]
    layout: Literal["control", "phases", "speed"] = "control"
    divisor: Annotated[int, Field(ge=1, le=2_500)] = 1
    centring: bool = True

    @model_validator(mode="after")
    def _ramps_fit_the_record(self) -> "RecordStep":
        ramp_s = getattr(self.excitation, "ramp_s", 0.0)  # set-points have none
        if 2.0 * ramp_s > self.duration_s:
            message = (
                "excitation.ramp_s of {ramp} s fades in and out and needs duration_s of at least {least} s"
            )
            raise PydanticCustomError("rule", message, {"ramp": ramp_s, "least": 2.0 * ramp_s})
        return self


class IdentifyStep(StrictModel):
    """Identify a model on one record and test it on another."""

    step: Literal["identify"]
    train: StepName
    test: StepName
    sample_time_s: Annotated[Seconds, Field(gt=0, le=10)] = 0.2
    order: Annotated[int, Field(ge=1, le=8)] = 2
    delay: Annotated[int, Field(ge=1, le=50)] = 1
    methods: Annotated[tuple[str, ...], Field(min_length=1)] = ("rls", "erls", "rls_kf")
    options: dict[str, float] = Field(default_factory=dict)
    input: str | None = None
    output: str = DEFAULT_OUTPUT


class GapStep(StrictModel):
    """Find what a joint's model lacks, from records of this campaign."""

    step: Literal["gap"]
    model: Path
    train: Annotated[tuple[StepName, ...], Field(min_length=1), BeforeValidator(_as_list)]
    test: Annotated[tuple[StepName, ...], Field(min_length=1), BeforeValidator(_as_list)]


class WaitStep(StrictModel):
    """Let the rig rest, for example to cool down."""

    step: Literal["wait"]
    seconds: Annotated[Seconds, Field(gt=0, le=86_400)]


class SetStep(StrictModel):
    """Set one parameter of the controller, in SI units."""

    step: Literal["set"]
    parameter: Annotated[str, Field(min_length=1)]
    value: float


STEPS: dict[str, type[StrictModel]] = {
    "record": RecordStep,
    "identify": IdentifyStep,
    "gap": GapStep,
    "wait": WaitStep,
    "set": SetStep,
}


def _unwrap(entry: Any) -> Any:  # Any: whatever stood in the YAML file
    """Turn `{record: {...}}` into `{step: record, ...}`, the form that the union tells apart."""
    if not isinstance(entry, dict) or len(entry) != 1:
        shown = ", ".join(map(str, entry)) if isinstance(entry, dict) else repr(entry)
        raise PydanticCustomError(
            "rule",
            "a step is one key with its settings below it, not {shown}; allowed: {allowed}",
            {"shown": shown or "nothing", "allowed": ", ".join(STEPS)},
        )
    ((kind, body),) = entry.items()
    if kind not in STEPS:
        message = 'unknown step "{kind}"{suggestion} allowed: {allowed}'
        details = {
            "kind": str(kind),
            "suggestion": suggest(str(kind), STEPS) or ";",
            "allowed": ", ".join(STEPS),
        }
        raise PydanticCustomError("rule", message, details)
    if not isinstance(body, dict):
        raise PydanticCustomError(
            "rule", "{kind} needs its settings below it as keys and values", {"kind": kind}
        )
    return {**body, STEP_TAG: kind}


Step = Annotated[
    Annotated[RecordStep | IdentifyStep | GapStep | WaitStep | SetStep, Field(discriminator=STEP_TAG)],
    BeforeValidator(_unwrap),
]


class Campaign(StrictModel):
    """One campaign file.

    Attributes:
        name: what the run folder and the manifest are called after.
        rig: rig file, relative to the campaign file; `--rig` replaces it.
        operator: who is responsible; written into every recording.
        steps: what to do, in order.
    """

    name: StepName
    description: str = ""
    rig: Path | None = None
    operator: str = ""
    steps: Annotated[tuple[Step, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _records_exist_before_use(self) -> "Campaign":
        records: list[str] = []
        for index, step in enumerate(self.steps):
            if isinstance(step, RecordStep):
                if step.name in records:
                    _refuse(index, "record.name", f'"{step.name}" stands twice; records need different names')
                records.append(step.name)
            if isinstance(step, IdentifyStep | GapStep):
                for field in ("train", "test"):
                    names = getattr(step, field)
                    for name in (names,) if isinstance(names, str) else names:
                        _require_record(index, f"{step.step}.{field}", name, records)
        return self


def _require_record(index: int, field: str, name: str, records: list[str]) -> None:
    if name in records:
        return
    known = ", ".join(records) or "none"
    hint = suggest(name, records) or ";"
    _refuse(
        index,
        field,
        f'no record step before this one is called "{name}"{hint} there is: {known}',
    )


def _refuse(index: int, field: str, message: str) -> None:
    step, name = field.split(".")
    raise PydanticCustomError(
        "rule_at", "{message}", {"message": message, "at": ("steps", index, step, name)}
    )
