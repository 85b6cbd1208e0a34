"""Run a planned campaign: connect, play the steps in order, keep the manifest up to date.

The drive is on only inside a record step, which brings it to rest however it ends. A stop request or Ctrl-C
ends the step under way; the rest of the campaign is then not started.
"""

import contextlib
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from daq.errors import DeviceFaultError, DeviceRefusedError, ProtocolVersionError
from server.errors import CampaignStoppedError, InputError, RigTrippedError
from server.services.discrepancy import GapAnalysis
from server.services.identification import Identification
from server.services.manifest import Ended, Manifest, StepEntry, describe_source, now
from server.services.plan import CampaignPlan, PlannedStep
from server.services.progress import ProgressListener
from server.services.recording import describe_controller
from server.services.rig_access import connected_rig
from server.services.steps import StepContext, perform_step

# The first entry that an error is an instance of says how a step or run ended; anything else failed.
ENDED_BY: tuple[tuple[type[BaseException], Ended], ...] = (
    (CampaignStoppedError, Ended.INTERRUPTED),
    (KeyboardInterrupt, Ended.INTERRUPTED),
    (RigTrippedError, Ended.TRIPPED),
    (DeviceFaultError, Ended.TRIPPED),
    (DeviceRefusedError, Ended.REFUSED),
    (ProtocolVersionError, Ended.REFUSED),
    (InputError, Ended.REFUSED),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignResult:
    """A campaign that was played to its end.

    Attributes:
        manifest: what also stands in the folder.
        identifications: results, each with the folder that it was written to.
        gaps: answers of the discrepancy workflow.
    """

    manifest: Manifest
    identifications: tuple[tuple[Identification, Path], ...]
    gaps: tuple[GapAnalysis, ...]


def run_campaign(
    plan: CampaignPlan, folder: Path, listener: ProgressListener, stop: threading.Event
) -> CampaignResult:
    """Play all steps of a plan.

    Args:
        plan: what to do.
        folder: run folder, without an earlier run.
        listener: told what happens.
        stop: set it from a signal handler or another thread to end the run; the drive comes to rest first.

    Raises:
        InputError: the rig cannot be reached, or does not take a value of the campaign.
        RigTrippedError: the drive tripped; what was recorded is whole.
        CampaignStoppedError: stopped; what was recorded is whole.
        RunFailedError: the link was lost or the disk is full; what was recorded is whole.
        DaqError: the rig refused.
    """
    folder.mkdir(parents=True, exist_ok=True)
    manifest = new_manifest(plan)
    with (
        accounting(manifest, folder, manifest),
        connected_rig(plan.rig, plan.rig_path, listener.note) as driver,
    ):
        manifest.rig["controller"] = describe_controller(driver)
        if plan.clear_fault:
            driver.clear_fault()
        context = StepContext(plan=plan, folder=folder, listener=listener, stop=stop, driver=driver)
        for planned, entry in zip(plan.steps, manifest.steps, strict=True):
            play_step(context, planned, entry, manifest)
    return CampaignResult(
        manifest=manifest, identifications=tuple(context.identifications), gaps=tuple(context.gaps)
    )


def how_it_ended(error: BaseException) -> Ended:
    """Return what the manifest says of a step or a run that ended with this error."""
    return next((ended for kind, ended in ENDED_BY if isinstance(error, kind)), Ended.FAILED)


def play_step(context: StepContext, planned: PlannedStep, entry: StepEntry, manifest: Manifest) -> None:
    """Play one step and write down in the manifest how it ended; raises what `perform_step` raises."""
    if context.stop.is_set():
        raise CampaignStoppedError(f"stopped before {planned.title}")
    entry.started, entry.ended = now(), Ended.RUNNING
    context.listener.step_started(entry.index, len(manifest.steps), planned.title)
    try:
        with accounting(entry, context.folder, manifest):
            perform_step(context, planned, entry)
    finally:
        context.listener.step_ended(planned.title, entry.ended.value, entry.message or _summary(entry))


@contextlib.contextmanager
def accounting(account: Manifest | StepEntry, folder: Path, manifest: Manifest) -> Iterator[None]:
    """Write into the manifest how a run, or one of its steps, ended, whatever ends it."""
    try:
        yield
    except BaseException as error:
        account.ended, account.message = how_it_ended(error), " ".join(str(error).split())
        raise
    else:
        account.ended = Ended.DONE
    finally:
        account.ended_at = now()
        manifest.write(folder)


def new_manifest(plan: CampaignPlan) -> Manifest:
    """Return the manifest of a run that begins now."""
    return Manifest(
        campaign={"name": plan.campaign.name, **describe_source(plan.campaign_path)},
        rig={"name": plan.rig.name, "url": plan.rig.link.url, **describe_source(plan.rig_path)},
        steps=[
            StepEntry(index=index, kind=planned.step.step, title=planned.title)
            for index, planned in enumerate(plan.steps)
        ],
        started=now(),
        operator=plan.campaign.operator,
    )


def _summary(entry: StepEntry) -> str:
    received, lost = entry.figures.get("samples_received"), entry.figures.get("samples_lost")
    return f"{received:,} samples, {lost} lost" if isinstance(received, int) else ""
