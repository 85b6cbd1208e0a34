"""What a job is, what it tells while it runs, and who is told of its samples."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from daq.driver.outcome import RecordProgress
from daq.protocol.stream import SampleBlock
from server.config.campaign import RecordStep
from server.services.jobs.machine import Happening
from server.services.manifest import Manifest, StepEntry
from server.services.plan import CampaignPlan
from server.services.rigs.served_rig import ServedRig
from server.services.steps import SampleWatch, StepContext
from server.services.tokens import Principal


class JobBook(Protocol):
    """Writes down what a job does; called by the job's thread."""

    def happened(self, happening: Happening, reason: str) -> None:
        """Take note of a change of state."""

    def step_changed(self, entry: StepEntry) -> None:
        """Take note of a step that began or ended."""

    def recorded(self, entry: StepEntry, path: Path) -> None:
        """Take note of a new recording."""


@dataclass(frozen=True, slots=True, kw_only=True)
class JobOrder:
    """What to do.

    Attributes:
        id: of the session or campaign.
        title: what the rig is said to be busy with.
        rig: the rig.
        who: who submitted it, and holds the rig while it runs.
        plan: steps, checked.
        folder: run folder; its files are relative to it.
        watch: told of samples, besides the viewers.
        finish: what is still done after a stop; may be None.
    """

    id: str
    title: str
    rig: ServedRig
    who: Principal
    plan: CampaignPlan
    folder: Path
    watch: SampleWatch | None = None
    finish: Callable[[StepContext, Manifest], None] | None = None


@dataclass(slots=True)
class JobProgress:
    """Where a running job is; replaced field by field, read by anybody.

    Attributes:
        step: index of the step under way.
        steps: how many there are.
        title: of the step.
        done_s, total_s: of the step, in the rig's own time.
        detail: samples received and lost, in words.
        samples_received, samples_expected, samples_lost: of the record under way.
        notes: what the steps said, newest last.
    """

    step: int = 0
    steps: int = 0
    title: str = ""
    done_s: float = 0.0
    total_s: float = 0.0
    detail: str = ""
    samples_received: int = 0
    samples_expected: int = 0
    samples_lost: int = 0
    notes: list[str] = field(default_factory=list)


@dataclass(slots=True)
class KeepingListener:
    """Keeps what the steps tell, for whoever asks."""

    kept: JobProgress

    def step_started(self, index: int, count: int, title: str) -> None:
        """Take note of a step that begins."""
        self.kept.step, self.kept.steps, self.kept.title = index, count, title
        self.kept.done_s = self.kept.total_s = 0.0
        self.kept.detail = ""

    def step_progress(self, done_s: float, total_s: float, detail: str) -> None:
        """Take note of how far it is."""
        self.kept.done_s, self.kept.total_s, self.kept.detail = done_s, total_s, detail

    def step_ended(self, title: str, ended: str, detail: str) -> None:
        """Take note of how it ended."""
        self.kept.detail = f"{ended}: {detail}" if detail else ended

    def note(self, text: str) -> None:
        """Keep the newest twenty remarks."""
        self.kept.notes = [*self.kept.notes[-19:], text]


@dataclass(slots=True)
class JobWatch:
    """Gives samples to the viewers, whose queues drop what they do not read, and to the job's own estimators."""

    rig: ServedRig
    kept: JobProgress
    also: SampleWatch | None

    def begin(self, step: RecordStep, journal: Path) -> None:
        """Get ready for a record."""
        if self.also is not None:
            self.also.begin(step, journal)

    def take(self, blocks: list[SampleBlock]) -> None:
        """Hand samples on."""
        self.rig.worker.publish(blocks)
        if self.also is not None:
            self.also.take(blocks)

    def progress(self, progress: RecordProgress) -> None:
        """Keep the counts of the record under way."""
        self.kept.samples_received = progress.samples
        self.kept.samples_lost = progress.samples_lost
        self.kept.samples_expected = progress.samples + progress.samples_lost
        if self.also is not None:
            self.also.progress(progress)

    def end(self) -> None:
        """Take note that the record has ended."""
        if self.also is not None:
            self.also.end()
