"""Excitations in campaign files: one model for each generator of the controller, plus tables and set-points.

`to_spec` turns the checked text into what `daq.excitation` plays. Limits of the rig are not judged here.
"""

# ruff: noqa: N815  # keys end in their unit, and a unit keeps its case

from typing import Annotated, Literal, TypedDict

from pydantic import Field

from daq.excitation import spec
from daq.protocol.codes import ChirpMode, StaircaseMode
from server.config.model import StrictModel
from server.config.units import Amperes, Hertz, Seconds

Spec = spec.Excitation | spec.Setpoints
Turns = Annotated[float, Field(ge=0, lt=1)]
Period = Annotated[Seconds, Field(gt=0, le=86_400)]
Frequency = Annotated[Hertz, Field(gt=0, le=625)]
Seed = Annotated[int, Field(ge=1, le=2**32 - 1)]


class ShapeFields(TypedDict):
    """What all generators share, named as in `daq.excitation.spec`."""

    amplitude_a: float
    offset_a: float
    ramp_s: float


class Shape(StrictModel):
    """What all generators share: peak current, constant part, fade-in and fade-out."""

    amplitude_A: Annotated[Amperes, Field(gt=0, le=4)]
    offset_A: Annotated[Amperes, Field(ge=-4, le=4)] = 0.0
    ramp_s: Annotated[Seconds, Field(ge=0, le=26)] = 0.0


class SineModel(Shape):
    """A sine of one period."""

    kind: Literal["sine"]
    period_s: Period
    phase_turns: Turns = 0.0

    def to_spec(self, duration_s: float) -> Spec:
        """Return what the driver plays."""
        return spec.Sine(
            **_shape(self), duration_s=duration_s, period_s=self.period_s, phase_turns=self.phase_turns
        )


class TrapezoidModel(Shape):
    """An odd trapezoid; `rise_fraction` is the way from -1 to +1 as a share of the period."""

    kind: Literal["trapezoid"]
    period_s: Period
    rise_fraction: Annotated[float, Field(gt=0, le=0.5)]
    phase_turns: Turns = 0.0

    def to_spec(self, duration_s: float) -> Spec:
        """Return what the driver plays."""
        return spec.Trapezoid(
            **_shape(self),
            duration_s=duration_s,
            period_s=self.period_s,
            rise_fraction=self.rise_fraction,
            phase_turns=self.phase_turns,
        )


class ChirpModel(Shape):
    """A sweep, repeated until the record ends."""

    kind: Literal["chirp"]
    sweep_s: Period
    start_Hz: Frequency
    end_Hz: Frequency
    spacing: Literal["linear", "logarithmic"] = "linear"
    phase_turns: Turns = 0.0

    def to_spec(self, duration_s: float) -> Spec:
        """Return what the driver plays."""
        return spec.Chirp(
            **_shape(self),
            duration_s=duration_s,
            repeat=True,
            sweep_s=self.sweep_s,
            start_hz=self.start_Hz,
            end_hz=self.end_Hz,
            mode=ChirpMode[self.spacing.upper()],
            phase_turns=self.phase_turns,
        )


class PrbsModel(Shape):
    """A pseudo-random binary sequence."""

    kind: Literal["prbs"]
    register_bits: Literal[5, 6, 7, 9, 10, 11, 15, 17, 18, 20, 23, 31]
    bit_s: Period
    seed: Seed = 1

    def to_spec(self, duration_s: float) -> Spec:
        """Return what the driver plays."""
        return spec.Prbs(
            **_shape(self),
            duration_s=duration_s,
            register_bits=self.register_bits,
            bit_s=self.bit_s,
            seed=self.seed,
        )


class StaircaseModel(Shape):
    """Equidistant levels, each held, repeated until the record ends."""

    kind: Literal["staircase"]
    levels: Annotated[int, Field(ge=2, le=1024)]
    level_s: Period
    order: Literal["up", "up_down", "from_zero"] = "from_zero"

    def to_spec(self, duration_s: float) -> Spec:
        """Return what the driver plays."""
        mode = StaircaseMode[self.order.upper()]
        return spec.Staircase(
            **_shape(self),
            duration_s=duration_s,
            repeat=True,
            levels=self.levels,
            level_s=self.level_s,
            mode=mode,
        )


class MultisineModel(Shape):
    """A sum of sines on harmonics of 1 / `period_s` with random phases, normalised to its peak."""

    kind: Literal["multisine"]
    period_s: Period
    lines: Annotated[int, Field(ge=1, le=64)]
    lowest: Annotated[int, Field(ge=1, le=1024)] = 1
    step: Annotated[int, Field(ge=1, le=1024)] = 1
    seed: Seed = 1

    def to_spec(self, duration_s: float) -> Spec:
        """Return what the driver plays."""
        return spec.Multisine(
            **_shape(self),
            duration_s=duration_s,
            period_s=self.period_s,
            lines=self.lines,
            lowest=self.lowest,
            step=self.step,
            seed=self.seed,
        )


class TableModel(StrictModel):
    """Currents uploaded to the controller before the run and repeated until the record ends."""

    kind: Literal["table"]
    values_A: Annotated[tuple[Amperes, ...], Field(min_length=1, max_length=1024)]
    hold_s: Period
    ramp_s: Annotated[Seconds, Field(ge=0, le=26)] = 0.0

    def to_spec(self, duration_s: float) -> Spec:
        """Return what the driver plays."""
        return spec.Table(
            values_a=self.values_A, hold_s=self.hold_s, ramp_s=self.ramp_s, duration_s=duration_s, repeat=True
        )


class SetpointsModel(StrictModel):
    """Currents streamed from the host while they are played."""

    kind: Literal["setpoints"]
    values_A: Annotated[tuple[Amperes, ...], Field(min_length=1)]
    hold_s: Annotated[Seconds, Field(gt=0, le=26)]

    def to_spec(self, duration_s: float) -> Spec:
        """Return what the driver plays; the values are repeated to fill the record."""
        count = max(1, round(duration_s / self.hold_s))
        repeats = -(-count // len(self.values_A))
        return spec.Setpoints(values_a=(self.values_A * repeats)[:count], hold_s=self.hold_s)


Excitation = Annotated[
    SineModel
    | TrapezoidModel
    | ChirpModel
    | PrbsModel
    | StaircaseModel
    | MultisineModel
    | TableModel
    | SetpointsModel,
    Field(discriminator="kind"),
]


def _shape(model: Shape) -> ShapeFields:
    return {"amplitude_a": model.amplitude_A, "offset_a": model.offset_A, "ramp_s": model.ramp_s}
