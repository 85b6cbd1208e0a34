"""From the names on the command line to a campaign plan: files read, defaults filled in, all checked."""

from dataclasses import dataclass, replace
from pathlib import Path

from server.config.campaign import Campaign
from server.config.load import load_model
from server.config.rig import EMULATE, Rig
from server.errors import InputError, InputLocation
from server.services.plan import CampaignPlan, plan_campaign


@dataclass(frozen=True, slots=True, kw_only=True)
class RunChoices:
    """What the user chose; None leaves it to the files.

    Attributes:
        campaign: campaign file.
        rig: rig file instead of the campaign's own.
        emulate: scenario to emulate instead of the rig file's port.
        speed: `max`, or a factor of real time, for the emulated controller.
        clear_fault: clear what the controller has latched before the first step.
    """

    campaign: Path
    rig: Path | None = None
    emulate: Path | None = None
    speed: str | None = None
    clear_fault: bool = False


def load_plan(choices: RunChoices) -> CampaignPlan:
    """Read campaign and rig and check every step.

    Raises:
        InputError: any of it is wrong; nothing was started.
    """
    campaign = load_model(choices.campaign, Campaign)
    rig_path = _rig_path(choices, campaign)
    rig = load_rig(rig_path, emulate=choices.emulate, speed=choices.speed)
    plan = plan_campaign(campaign, choices.campaign, rig, rig_path)
    return replace(plan, clear_fault=choices.clear_fault)


def load_rig(path: Path, *, emulate: Path | None = None, speed: str | None = None) -> Rig:
    """Return a rig file with its scenario and model as paths from here, and with the user's choices in force.

    Args:
        path: rig file.
        emulate: scenario to emulate instead of the file's port.
        speed: `max`, or a factor of real time, for the emulated controller.

    Raises:
        InputError: the file is wrong, or there is no such scenario.
    """
    rig = load_model(path, Rig)
    changes: dict[str, object] = {}
    if rig.scenario is not None:
        changes["scenario"] = path.parent / rig.scenario
    if rig.model is not None:
        changes["model"] = path.parent / rig.model
    if emulate is not None:
        changes |= {"scenario": emulate, "link": rig.link.model_copy(update={"url": EMULATE})}
    if speed is not None:
        changes["emulation_speed"] = parse_speed(speed)
    changed = rig.model_copy(update=changes)
    if changed.link.url == EMULATE and changed.scenario is not None and not changed.scenario.is_file():
        raise InputError(
            "no such scenario file; see config/scenarios/", InputLocation(source=changed.scenario)
        )
    return changed


def _rig_path(choices: RunChoices, campaign: Campaign) -> Path:
    if choices.rig is not None:
        return choices.rig
    if campaign.rig is None:
        raise InputError(
            "names no rig; add the key rig or give --rig", InputLocation(source=choices.campaign)
        )
    return choices.campaign.parent / campaign.rig


def parse_speed(text: str) -> str | float:
    """Return `max` or the factor of real time that the user gave for an emulated controller.

    Raises:
        InputError: it is neither.
    """
    if text == "max":
        return text
    try:
        factor = float(text)
    except ValueError:
        factor = 0.0
    if not 0.0 < factor <= 1000.0:
        raise InputError(f'"{text}" is neither max nor a factor up to 1000', InputLocation(field="--speed"))
    return factor
