"""What a recording reports while it runs and when it has ended."""

from dataclasses import dataclass
from enum import Enum

from daq.errors import DaqError
from daq.excitation.check import ExcitationReport


class RecordEnd(Enum):
    """How a recording ended."""

    DONE = "done"
    STOPPED = "stopped"
    TRIPPED = "tripped"
    LINK_LOST = "link_lost"
    DISK_FULL = "disk_full"


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordProgress:
    """Where a recording is.

    Attributes:
        elapsed_s: Device time since the excitation's first tick, s.
        duration_s: Length asked for, s.
        samples: Samples received.
        samples_lost: Samples known to be missing.
        link_up: False while a lost port is being looked for.
        trouble: What went wrong with the link in the last second, in plain words; empty when nothing did.
        start_tick: Controller tick of the excitation's first value, 64-bit axis; None before it is known.
    """

    elapsed_s: float
    duration_s: float
    samples: int
    samples_lost: int
    link_up: bool
    trouble: str
    start_tick: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordOutcome:
    """How a recording went.

    Attributes:
        end: How it ended.
        text: The same in a sentence; for a trip, the controller's text and remedy.
        report: What the excitation was predicted to do.
        start_tick: Controller tick of the excitation's first value, 64-bit axis.
        samples_expected: Received and lost together.
        samples_received: Samples received.
        samples_lost: Samples known to be missing.
        gaps: Holes in the samples.
        underruns: Times the controller ran out of set-points.
        error: What ended the recording, None for DONE and STOPPED.
    """

    end: RecordEnd
    text: str
    report: ExcitationReport
    start_tick: int
    samples_expected: int
    samples_received: int
    samples_lost: int
    gaps: int
    underruns: int
    error: DaqError | None
