"""From a submitted document to a plan for a rig of the service, with errors that name the request's own fields."""

from dataclasses import dataclass, replace
from pathlib import Path

from server.config.campaign import Campaign, GapStep
from server.config.load import load_model
from server.errors import InputError, InputLocation
from server.services.plan import CampaignPlan, plan_campaign
from server.services.rigs.served_rig import ServedRig

DOCUMENT = "campaign.yaml"


@dataclass(frozen=True, slots=True, kw_only=True)
class StepForecast:
    """What a step will do.

    Attributes:
        title, kind: of the step.
        duration_s: in the rig's own time.
        samples, line_use: of a record step, else None.
        peak_current_A, rms_current_A, peak_speed_rad_s, position_min_rad, position_max_rad: predicted.
    """

    title: str
    kind: str
    duration_s: float
    samples: int | None = None
    line_use: float | None = None
    predicted: dict[str, float] | None = None


def load_document(path: Path) -> Campaign:
    """Read a submitted campaign that was written to `path`.

    Raises:
        InputError: something in it is wrong; the message names no file of the server.
    """
    try:
        return load_model(path, Campaign)
    except InputError as error:
        raise without_path(error) from error


def plan_document(campaign: Campaign, path: Path, rig: ServedRig, models: Path | None) -> CampaignPlan:
    """Check every step against a rig's limits.

    Args:
        campaign: content of `path`.
        path: where the document is kept.
        rig: what it shall run on.
        models: folder of model files that `gap` steps may name; None for none.

    Raises:
        InputError: a step exceeds a limit, or names something unknown.
    """
    try:
        campaign = _with_models(campaign, models)
        return plan_campaign(campaign, path, rig.rig, rig.path)
    except InputError as error:
        raise without_path(error) from error


def forecast(plan: CampaignPlan) -> list[StepForecast]:
    """Return what each step will do."""
    steps = []
    for planned in plan.steps:
        step = StepForecast(title=planned.title, kind=planned.step.step, duration_s=planned.duration_s)
        if planned.record is not None:
            report = planned.record.report
            step = replace(
                step,
                samples=planned.record.samples,
                line_use=planned.record.line_use,
                predicted={name: float(getattr(report, name)) for name in report.__dataclass_fields__},
            )
        steps.append(step)
    return steps


def without_path(error: InputError) -> InputError:
    """Return the error without the path of the server's own copy of the document."""
    where = error.location
    text = str(error.args[0]).removeprefix(f"{where}: ") if str(where) else str(error.args[0])
    return InputError(text, InputLocation(source="campaign", line=where.line, field=where.field))


def _with_models(campaign: Campaign, models: Path | None) -> Campaign:
    """Let `gap` steps name models of the service by their file's name, and no other file of this machine."""
    steps = []
    for index, step in enumerate(campaign.steps):
        if isinstance(step, GapStep):
            known = {} if models is None else {path.name: path for path in sorted(models.glob("*.yaml"))}
            found = known.get(step.model.name)
            if found is None:
                raise InputError(
                    f"no model {step.model.name}; this service has {', '.join(known) or 'none'}",
                    InputLocation(field=f"steps[{index}].gap.model"),
                )
            step = step.model_copy(update={"model": found.resolve()})
        steps.append(step)
    return campaign.model_copy(update={"steps": tuple(steps)})
