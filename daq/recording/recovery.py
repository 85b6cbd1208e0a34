"""What to do, at the start of the program, about journals that a killed process left behind.

A journal that is still locked belongs to a living process and is left alone; one with samples becomes a
recording; one without is archived; one that cannot be read stays where it is, so that a person can look at
it.
"""

from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from daq.errors import DaqError
from daq.recording.finalise import EmptyJournalError, JournalInUseError, archive_journal, finalise_journal
from daq.recording.journal import JOURNAL_SUFFIX


class RecoveryOutcome(Enum):
    """What became of a journal."""

    RECOVERED = "recovered"
    IN_USE = "in use"
    EMPTY = "empty"
    UNREADABLE = "unreadable"


@dataclass(frozen=True, slots=True, kw_only=True)
class RecoveryReport:
    """What was found and done about one journal.

    Attributes:
        journal: where it was.
        outcome: what became of it.
        recording: the recording made of it, None where none was.
        detail: one sentence for the operator.
    """

    journal: Path
    outcome: RecoveryOutcome
    recording: Path | None
    detail: str


def recover_journals(folder: Path, out_dir: Path | None = None) -> list[RecoveryReport]:
    """Finalise every journal in a folder that nobody writes any more.

    Args:
        folder: where journals are written.
        out_dir: where recordings go, the same folder by default.
    """
    return [_recover(path, out_dir or folder) for path in sorted(folder.glob("*" + JOURNAL_SUFFIX))]


def _recover(path: Path, out_dir: Path) -> RecoveryReport:
    try:
        recording = finalise_journal(path, out_dir)
    except JournalInUseError as error:
        return RecoveryReport(journal=path, outcome=RecoveryOutcome.IN_USE, recording=None, detail=str(error))
    except EmptyJournalError as error:
        archive = archive_journal(path, out_dir)
        detail = f"{error}; kept as {archive}"
        return RecoveryReport(journal=path, outcome=RecoveryOutcome.EMPTY, recording=None, detail=detail)
    except DaqError as error:
        return RecoveryReport(
            journal=path, outcome=RecoveryOutcome.UNREADABLE, recording=None, detail=str(error)
        )
    return RecoveryReport(
        journal=path,
        outcome=RecoveryOutcome.RECOVERED,
        recording=recording,
        detail=f"recovered {recording} from a journal that was left open",
    )
