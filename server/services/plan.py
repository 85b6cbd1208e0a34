"""What a campaign would do, worked out before anything moves: limits, travel, time and wire of every step.

`jointscope run` plans first and starts only when the whole plan holds; `--dry-run` stops there.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from daq.errors import ExcitationLimitError
from daq.excitation.check import ExcitationReport, check_excitation
from daq.protocol.budget import LINE_USE_LIMIT, default_batch, line_use, propose_stream
from server.config.campaign import Campaign, GapStep, IdentifyStep, RecordStep, SetStep, Step, WaitStep
from server.config.excitation import Spec
from server.config.load import locate_field
from server.config.rig import Rig
from server.errors import InputError, InputLocation
from server.services.errors import InvalidValueError
from server.services.limits import TICK_HZ, rig_joint, rig_limits, start_condition

# Channels of the standard layouts (docs/protocol.md); at run time the controller's dictionary decides.
LAYOUT_CHANNELS = {"control": 3, "phases": 5, "speed": 4}


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedRecord:
    """One record step, predicted.

    Attributes:
        spec: what the driver plays.
        report: current, heat, speed and travel.
        line_use: share of the line that the stream takes.
        samples: samples that will be recorded.
    """

    spec: Spec
    report: ExcitationReport
    line_use: float
    samples: int


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedStep:
    """One step of the plan; `record` only for steps that move the rig."""

    step: Step
    title: str
    duration_s: float = 0.0
    record: PlannedRecord | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignPlan:
    """A campaign that holds against the limits of its rig file; `clear_fault` clears a latched fault first."""

    campaign: Campaign
    campaign_path: Path
    rig: Rig
    rig_path: Path
    steps: tuple[PlannedStep, ...]
    clear_fault: bool = False

    @property
    def duration_s(self) -> float:
        """Time that the rig is busy, in its own time."""
        return sum(step.duration_s for step in self.steps)


@dataclass(slots=True)
class _Planner:
    rig: Rig
    campaign_path: Path
    parameters: dict[str, float] = field(default_factory=dict)

    def plan(self, index: int, step: Step) -> PlannedStep:
        if isinstance(step, RecordStep):
            return self._plan_record(index, step)
        if isinstance(step, SetStep):
            self.parameters[step.parameter] = step.value
            return PlannedStep(step=step, title=f"set {step.parameter} = {step.value:g}")
        if isinstance(step, WaitStep):
            return PlannedStep(step=step, title=f"wait {step.seconds:g} s", duration_s=step.seconds)
        if isinstance(step, GapStep):
            return self._plan_gap(index, step)
        check_methods(step.methods, lambda: self._at(index, "identify", "methods"))
        self._check_options(index, step)
        return PlannedStep(step=step, title=_identify_title(step))

    def _check_options(self, index: int, step: IdentifyStep) -> None:
        from server.services.estimator_choice import check_option_for

        for name, value in step.options.items():
            try:
                check_option_for(step.methods, name, value)
            except InvalidValueError as error:
                where = self._at(index, "identify", "options")
                raise InputError(f"{error}; {error.remedy}", where) from error

    def _plan_gap(self, index: int, step: GapStep) -> PlannedStep:
        """Read the model now: a mistake in it should not come to light after the recordings."""
        from server.services.discrepancy import read_joint_model

        path = self.campaign_path.parent / step.model
        if not path.is_file():
            raise InputError(f"no such model file: {path}", self._at(index, "gap", "model"))
        read_joint_model(path)
        title = f"gap of {path.stem} on {', '.join(step.train)}, test on {', '.join(step.test)}"
        return PlannedStep(step=step, title=title)

    def _plan_record(self, index: int, step: RecordStep) -> PlannedStep:
        report, spec = self._check(index, step)
        use = self._line_use(index, step)
        record = PlannedRecord(
            spec=spec, report=report, line_use=use, samples=round(step.duration_s * TICK_HZ / step.divisor)
        )
        title = f"record {step.name} ({step.excitation.kind}, {step.duration_s:g} s)"
        return PlannedStep(step=step, title=title, duration_s=step.duration_s, record=record)

    def _line_use(self, index: int, step: RecordStep) -> float:
        baud, channels = int(self.rig.link.baud), LAYOUT_CHANNELS[step.layout]
        use = line_use(baud, channels, default_batch(channels), step.divisor, TICK_HZ)
        if use <= LINE_USE_LIMIT:
            return use
        fitting = propose_stream(baud, channels, TICK_HZ)
        remedy = f"use divisor {fitting.divisor}" if fitting else "use a higher baud rate"
        raise InputError(
            f"layout {step.layout} with divisor {step.divisor} takes {use:.0%} of a line of {baud} Bd, "
            f"above the {LINE_USE_LIMIT:.0%} allowed; {remedy}",
            self._at(index, "record", "divisor"),
        )

    def _check(self, index: int, step: RecordStep) -> tuple[ExcitationReport, Spec]:
        start = start_condition(self.parameters, centring=step.centring)
        spec = step.excitation.to_spec(step.duration_s)
        joint = rig_joint(self.rig)
        try:
            return check_excitation(spec, rig_limits(self.rig), joint, start), spec
        except (ExcitationLimitError, ValueError) as error:
            raise InputError(str(error), self._at(index, "record", "excitation")) from error

    def _at(self, index: int, kind: str, name: str) -> InputLocation:
        return locate_field(self.campaign_path, ("steps", index, kind, name))


def plan_campaign(campaign: Campaign, campaign_path: Path, rig: Rig, rig_path: Path) -> CampaignPlan:
    """Check every step and predict what it does.

    Raises:
        InputError: a step would exceed a limit of the rig file, the line, or names something unknown.
    """
    planner = _Planner(rig, campaign_path, dict(rig.parameters))
    steps = tuple(planner.plan(index, step) for index, step in enumerate(campaign.steps))
    return CampaignPlan(
        campaign=campaign, campaign_path=campaign_path, rig=rig, rig_path=rig_path, steps=steps
    )


def check_methods(methods: tuple[str, ...], where: Callable[[], InputLocation]) -> None:
    """Refuse an estimator that does not exist, before anything is recorded for it."""
    from estimators.table import find_estimator

    for method in methods:
        try:
            find_estimator(method)
        except ValueError as error:
            raise InputError(str(error), where()) from error


def _identify_title(step: IdentifyStep) -> str:
    return f"identify on {step.train}, test on {step.test}"
