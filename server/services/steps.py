"""What each kind of campaign step does on an open rig."""

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol, TypeVar

from daq.driver.outcome import RecordEnd, RecordOutcome, RecordProgress
from daq.driver.rig import Rig as DriverRig
from daq.errors import DeviceFaultError, ExcitationLimitError
from daq.protocol.stream import SampleBlock
from server.config.campaign import GapStep, IdentifyStep, RecordStep, SetStep, WaitStep
from server.config.load import locate_field
from server.errors import CampaignStoppedError, InputError, InputLocation, RigTrippedError, RunFailedError
from server.services.dataset import Signals
from server.services.discrepancy import GapAnalysis, GapRequest, run_gap_analysis
from server.services.identification import Identification, IdentifyRequest, run_identification
from server.services.manifest import StepEntry
from server.services.plan import CampaignPlan, PlannedStep
from server.services.progress import ProgressListener
from server.services.recording import RecordingResult, RecordingTask, make_recording
from server.services.run_folder import RECORDS

# How often a waiting step looks at the rig's time and at a stop request.
POLL_S = 0.05
TICK_MODULUS = 2**32
T = TypeVar("T")


class OnRig(Protocol):
    """Lets work that pulls samples run where the rig's samples are pulled."""

    def __call__(self, title: str, work: Callable[[DriverRig], T], stop: threading.Event) -> T:
        """Do the work and return its result; `stop` ends it early."""


class SampleWatch(Protocol):
    """Told of a record step's samples as they come; runs in the data task, so it must be quick."""

    def begin(self, step: RecordStep, journal: Path) -> None:
        """Get ready for a record step whose journal is being written to this file."""

    def take(self, blocks: list[SampleBlock]) -> None:
        """Take samples."""

    def progress(self, progress: RecordProgress) -> None:
        """Take note of where the record is."""

    def end(self) -> None:
        """Take note that the record has ended; called by the thread that called `begin`."""


@dataclass(slots=True)
class StepContext:
    """What the steps of one run share.

    Attributes:
        plan: the campaign.
        folder: run folder.
        listener: told how far a step is.
        stop: set to end the run early.
        driver: the open rig, to be asked.
        on_rig: does what pulls samples; None does it in the caller's thread.
        watch: told of a record's samples.
        identifications: results so far, with the folder that each was written to.
        gaps: answers of the discrepancy workflow so far.
    """

    plan: CampaignPlan
    folder: Path
    listener: ProgressListener
    stop: threading.Event
    driver: DriverRig
    on_rig: OnRig | None = None
    watch: SampleWatch | None = None
    identifications: list[tuple[Identification, Path]] = field(default_factory=list)
    gaps: list[GapAnalysis] = field(default_factory=list)

    def at(self, index: int, *names: str) -> InputLocation:
        """Return where a field of a step stands in the campaign file."""
        return locate_field(self.plan.campaign_path, ("steps", index, *names))

    def folder_for(self, kind: str) -> Path:
        """Return where the next analysis goes: the first where people look for it, others into their own."""
        number = len(self.identifications) + len(self.gaps) + 1
        return self.folder if number == 1 else self.folder / f"{kind}-{number}"

    def record_path(self, name: str) -> Path:
        """Return the recording of a record step."""
        return self.folder / RECORDS / f"{name}.parquet"


def perform_step(context: StepContext, planned: PlannedStep, entry: StepEntry) -> None:
    """Do one step and note its files and figures in `entry`.

    Raises:
        InputError: a value that the rig does not take, or recordings that cannot be identified.
        RigTrippedError: the drive tripped.
        CampaignStoppedError: stopped while under way.
        RunFailedError: link lost or disk full.
    """
    step = planned.step
    if isinstance(step, RecordStep):
        _record(context, planned, step, entry)
    elif isinstance(step, SetStep):
        _set(context, step, entry)
    elif isinstance(step, WaitStep):
        _wait(context, step)
    elif isinstance(step, GapStep):
        _gap(context, step, entry)
    else:
        _identify(context, step, entry)


def _record(context: StepContext, planned: PlannedStep, step: RecordStep, entry: StepEntry) -> None:
    if planned.record is None:
        raise ValueError(f"step {entry.index} was not planned as a record step")
    task = RecordingTask(
        step=step,
        spec=planned.record.spec,
        rig=context.plan.rig,
        operator=context.plan.campaign.operator,
        folder=context.folder / RECORDS,
    )
    try:
        result = _make_recording(context, planned, task)
    except ExcitationLimitError as error:
        raise InputError(str(error), context.at(entry.index, "record", "excitation")) from error
    except DeviceFaultError as error:  # latched before this run: nothing has moved
        told = f"nothing was moved: {error} A run with --clear-fault clears it."
        raise DeviceFaultError(told, faults=error.faults, tick=error.tick) from error
    if result.path is not None:
        entry.files.append(str(result.path.relative_to(context.folder)))
    entry.figures |= _figures(result.outcome)
    _raise_unless_done(result.outcome)


def _make_recording(context: StepContext, planned: PlannedStep, task: RecordingTask) -> RecordingResult:
    watch, stop, tell = context.watch, context.stop, _progress_teller(context)
    if watch is not None:
        watch.begin(task.step, task.journal)

    def work(driver: DriverRig) -> RecordingResult:
        return make_recording(driver, task, tell, stop, None if watch is None else watch.take)

    try:
        return work(context.driver) if context.on_rig is None else context.on_rig(planned.title, work, stop)
    finally:
        if watch is not None:
            watch.end()


def _progress_teller(context: StepContext) -> Callable[[RecordProgress], None]:
    def tell(progress: RecordProgress) -> None:
        lost = f", {progress.samples_lost} lost" if progress.samples_lost else ""
        trouble = f", {progress.trouble}" if progress.trouble else ""
        detail = f"{progress.samples:,} samples{lost}{trouble}"
        context.listener.step_progress(progress.elapsed_s, progress.duration_s, detail)
        if context.watch is not None:
            context.watch.progress(progress)

    return tell


def _figures(outcome: RecordOutcome) -> dict[str, object]:
    return {
        "samples_received": outcome.samples_received,
        "samples_expected": outcome.samples_expected,
        "samples_lost": outcome.samples_lost,
        "gaps": outcome.gaps,
        "underruns": outcome.underruns,
        "predicted_peak_current_A": outcome.report.peak_current_a,
        "predicted_travel_rad": [outcome.report.position_min_rad, outcome.report.position_max_rad],
    }


def _raise_unless_done(outcome: RecordOutcome) -> None:
    if outcome.end is RecordEnd.DONE:
        return
    if outcome.end is RecordEnd.TRIPPED:
        raise RigTrippedError(outcome.text) from outcome.error
    if outcome.end is RecordEnd.STOPPED:
        raise CampaignStoppedError(outcome.text)
    raise RunFailedError(outcome.text) from outcome.error


def _set(context: StepContext, step: SetStep, entry: StepEntry) -> None:
    try:
        in_force = context.driver.write_parameter(step.parameter, step.value)
    except KeyError as error:
        raise InputError(str(error.args[0]), context.at(entry.index, "set", "parameter")) from error
    except ValueError as error:
        raise InputError(str(error), context.at(entry.index, "set", "value")) from error
    entry.figures["in_force"] = in_force


def _wait(context: StepContext, step: WaitStep) -> None:
    """Wait in the rig's own time, but never longer on the wall clock: an emulated rig keeps its own pace."""
    driver, tick_hz = context.driver, context.driver.hello.tick_hz
    first_tick: int | None = None
    waited_s = elapsed_s = 0.0
    while max(waited_s, elapsed_s) < step.seconds:
        context.listener.step_progress(max(waited_s, elapsed_s), step.seconds, "")
        if context.stop.wait(POLL_S):
            raise CampaignStoppedError("stopped while waiting")
        waited_s += POLL_S
        if driver.status is not None:
            first_tick = driver.status.tick if first_tick is None else first_tick
            elapsed_s = (driver.status.tick - first_tick) % TICK_MODULUS / tick_hz


def _identify(context: StepContext, step: IdentifyStep, entry: StepEntry) -> None:
    out = context.folder_for("identify")
    request = IdentifyRequest(
        train=context.record_path(step.train),
        test=context.record_path(step.test),
        sample_time_s=step.sample_time_s,
        order=step.order,
        delay=step.delay,
        methods=step.methods,
        options=step.options,
        signals=Signals(input=step.input, output=step.output),
    )
    identification = run_identification(request, out, context.listener.note)
    context.identifications.append((identification, out))
    entry.files.append(str(identification.json_path.relative_to(context.folder)))


def _gap(context: StepContext, step: GapStep, entry: StepEntry) -> None:
    request = GapRequest(
        model=context.plan.campaign_path.parent / step.model,
        train=tuple(context.record_path(name) for name in step.train),
        test=tuple(context.record_path(name) for name in step.test),
        stop=context.stop,
    )
    analysis = run_gap_analysis(request, context.folder_for("gap"), context.listener.note)
    context.gaps.append(analysis)
    entry.files += [str(path.relative_to(context.folder)) for path in analysis.files]
    entry.figures |= {"verdict": analysis.result.verdict, "effects": list(analysis.result.effects)}
