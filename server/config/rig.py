"""The rig file: how to reach a controller, what the host allows it to do, and the nameplate used to predict.

`config/rigs/emulated.yaml` is the commented example of every key.
"""

# ruff: noqa: N815  # keys end in their unit, and a unit keeps its case

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from server.config.model import StrictModel
from server.config.units import (
    Amperes,
    AmperesPerSecond,
    Baud,
    KilogramSquareMetres,
    Milliseconds,
    NewtonMetreSecondsPerRadian,
    NewtonMetresPerAmpere,
    Radians,
    RadiansPerSecond,
    Seconds,
)

EMULATE = "emulate"


class Link(StrictModel):
    """How to reach the controller."""

    url: Annotated[str, Field(min_length=1)]
    baud: Annotated[Baud, Field(ge=9_600, le=12_000_000)] = 937_500.0
    lease_ms: Annotated[Milliseconds, Field(ge=50, le=2_000)] = 250.0


class Limits(StrictModel):
    """What the host refuses to ask for; the controller has its own limits and enforces them itself."""

    current_A: Annotated[Amperes, Field(gt=0, le=4)] = 2.0
    rated_current_A: Annotated[Amperes, Field(gt=0, le=4)] = 1.26
    i2t_time_s: Annotated[Seconds, Field(gt=0, le=600)] = 10.0
    slew_A_s: Annotated[AmperesPerSecond, Field(gt=0, le=100_000)] = 500.0
    speed_rad_s: Annotated[RadiansPerSecond, Field(gt=0, le=400)] = 180.0
    travel_min_rad: Annotated[Radians, Field(ge=-31.4, lt=0)] = -29.8
    travel_max_rad: Annotated[Radians, Field(gt=0, le=31.4)] = 29.8


class Nameplate(StrictModel):
    """The linear model that predicts travel and speed before anything moves; all at the motor shaft."""

    inertia_kg_m2: Annotated[KilogramSquareMetres, Field(gt=0)]
    viscous_friction_N_m_s_rad: Annotated[NewtonMetreSecondsPerRadian, Field(gt=0)]
    torque_constant_N_m_A: Annotated[NewtonMetresPerAmpere, Field(gt=0)]
    flux_current_A: Annotated[Amperes, Field(ge=0, le=4)] = 0.4455


class ChannelCalibration(StrictModel):
    """Replaces what the controller's dictionary says of one column: SI = (counts - offset_counts) * scale."""

    scale: Annotated[float, Field(gt=0)] | None = None
    offset_counts: float | None = None

    @model_validator(mode="after")
    def _something_to_replace(self) -> "ChannelCalibration":
        if self.scale is None and self.offset_counts is None:
            raise PydanticCustomError("rule", "give scale, offset_counts or both, or leave the column out")
        return self


class Rig(StrictModel):
    """One rig file.

    Attributes:
        name: what manifests and recordings call the rig.
        link: how to reach the controller; `url: emulate` starts an emulated one.
        limits: what the host refuses to ask for.
        nameplate: linear model for predictions.
        model: joint model file that predicts travel and speed instead, relative to the rig file.
        parameters: controller parameters, SI, written at the start of every run.
        calibration: by column name, what replaces the controller's own scale.
        scenario: scenario of the emulated controller, relative to the rig file.
        emulation_speed: 1 paces the emulated controller as the line would; `max`: as fast as the host reads.
        physics: what the emulated rig is made of; documentation, compared with the emulator by its tests.
    """

    name: Annotated[str, Field(min_length=1, pattern=r"^[\w.-]+$")]
    description: str = ""
    link: Link
    limits: Limits = Limits()
    nameplate: Nameplate
    model: Path | None = None
    parameters: dict[str, float] = Field(default_factory=dict)
    calibration: dict[str, ChannelCalibration] = Field(default_factory=dict)
    scenario: Path | None = None
    emulation_speed: Literal["max"] | Annotated[float, Field(gt=0, le=1000)] = "max"
    physics: dict[str, object] = Field(default_factory=dict)

    @field_validator("scenario", "model", mode="before")
    @classmethod
    def _path_from_text(cls, value: object) -> object:
        if value is not None and not isinstance(value, str | Path):
            raise PydanticCustomError("rule", "must be the path of a file")
        return value

    @model_validator(mode="after")
    def _emulation_needs_a_scenario(self) -> "Rig":
        if self.link.url == EMULATE and self.scenario is None:
            raise PydanticCustomError(
                "rule", 'link.url "emulate" needs the key scenario: the scenario file to emulate'
            )
        return self
