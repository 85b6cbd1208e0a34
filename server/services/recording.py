"""One record step: journal, excitation, samples, and the recording that is made of it."""

import threading
import uuid
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from daq.driver.options import RecordPlan, StreamPlan
from daq.driver.outcome import RecordOutcome, RecordProgress
from daq.driver.rig import Rig as DriverRig
from daq.driver.session import record
from daq.errors import JournalWriteError
from daq.protocol.stream import SampleBlock
from daq.recording.finalise import EmptyJournalError, finalise_journal
from daq.recording.header import make_header
from daq.recording.journal import JOURNAL_SUFFIX, Journal
from server.config.campaign import RecordStep
from server.config.excitation import Spec
from server.config.rig import Rig
from server.services.limits import rig_joint
from server.services.manifest import now
from server.services.rig_access import measured_calibration


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingTask:
    """What a record step needs besides the rig itself.

    Attributes:
        step: the step of the campaign.
        spec: what the driver plays.
        rig: the rig file.
        operator: from the campaign file.
        folder: where journal and recording go.
    """

    step: RecordStep
    spec: Spec
    rig: Rig
    operator: str
    folder: Path

    @property
    def journal(self) -> Path:
        """The journal while it is written."""
        return self.folder / (self.step.name + JOURNAL_SUFFIX)


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingResult:
    """A finished record step; `path` is None when not a single sample came."""

    outcome: RecordOutcome
    path: Path | None


def make_recording(
    driver: DriverRig,
    task: RecordingTask,
    on_progress: Callable[[RecordProgress], None],
    stop: threading.Event,
    on_blocks: Callable[[list[SampleBlock]], None] | None = None,
) -> RecordingResult:
    """Play a step's excitation, record it, and turn the journal into a recording, however it ended.

    `on_blocks` gets all samples as they come; it runs in the data task, so it must be quick.

    Raises:
        ExcitationLimitError: from where the joint stands now, a limit would be exceeded; nothing moved.
        DeviceRefusedError, DeviceFaultError: the controller refused before anything moved.
        JournalWriteError: the journal cannot be created.
    """
    task.folder.mkdir(parents=True, exist_ok=True)
    journal_path = task.journal
    journal = Journal.create(journal_path, _header(driver, task))
    reason = "aborted"
    try:
        outcome = record(driver, _plan(task), journal, on_progress, on_blocks, stop)
        reason = outcome.end.value
    finally:
        journal.close(reason)
    try:
        return RecordingResult(outcome=outcome, path=finalise_journal(journal_path, task.folder))
    except EmptyJournalError:
        return RecordingResult(outcome=outcome, path=None)
    except OSError as error:
        raise JournalWriteError(
            f"the journal {journal_path} is whole, but no recording could be made of it: {error.strerror}; "
            "free some space and start again in the same folder, which recovers it"
        ) from error


def _plan(task: RecordingTask) -> RecordPlan:
    step = task.step
    return RecordPlan(
        excitation=task.spec,
        duration_s=step.duration_s,
        nameplate=rig_joint(task.rig),
        slew_limit_a_s=task.rig.limits.slew_A_s,
        stream=StreamPlan(layout=step.layout, divisor=step.divisor),
        centring=step.centring,
        lease_ms=int(task.rig.link.lease_ms),
    )


def _header(driver: DriverRig, task: RecordingTask) -> Mapping[str, object]:
    hello = driver.hello
    return make_header(
        dictionary=driver.dictionary_octets,
        tick_hz=hello.tick_hz,
        divisor=task.step.divisor,
        details={
            "uid": str(uuid.uuid4()),
            "name": task.step.name,
            "started_utc": now(),
            "operator": task.operator,
            "rig": task.rig.name,
            "duration_s": task.step.duration_s,
            "excitation": task.step.excitation.model_dump(),
            "hello": describe_controller(driver),
            "calibration": measured_calibration(driver, task.rig),
        },
    )


def describe_controller(driver: DriverRig) -> dict[str, object]:
    """Return what the controller says of itself, as JSON values."""
    hello = driver.hello
    return {
        "device": driver.dictionary.device,
        "serial_number": hello.serial_number,
        "firmware": hello.firmware,
        "protocol": hello.version,
        "session": hello.session,
        "tick_hz": hello.tick_hz,
        "baud": driver.baud,
    }
