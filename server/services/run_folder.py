"""The folder of a run: where its files go, and what happens to those of an earlier run in the same place."""

import json
import shutil
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from daq.recording.recovery import RecoveryOutcome, recover_journals
from server.services.manifest import MANIFEST_NAME

RECORDS = "records"
PREVIOUS = "previous"


def default_folder(name: str) -> Path:
    """Return a new folder below `runs/` named after the campaign and the time of day."""
    return Path("runs") / f"{name}-{datetime.now().strftime('%Y%m%d-%H%M%S')}"


def recover_folder(folder: Path, tell: Callable[[str], None]) -> None:
    """Finalise journals that a killed run left open in this folder."""
    for report in recover_journals(folder / RECORDS):
        if report.outcome is not RecoveryOutcome.EMPTY:
            tell(report.detail)


def set_aside_previous(folder: Path) -> Path | None:
    """Move an earlier run's files into `previous/`, so that none is ever written over.

    Returns:
        Where they went; None if there was no earlier run.
    """
    if not (folder / MANIFEST_NAME).exists() and not (folder / RECORDS).exists():
        return None
    shelf = folder / PREVIOUS
    shelf.mkdir(exist_ok=True)
    target = shelf / f"{len(list(shelf.iterdir())) + 1:03d}"
    target.mkdir()
    for entry in list(folder.iterdir()):
        if entry != shelf:
            entry.rename(target / entry.name)
    return target


def remove_previous(folder: Path) -> None:
    """Delete an earlier run's files: exactly those that its manifest lists, and nothing else."""
    manifest = folder / MANIFEST_NAME
    try:
        listed = json.loads(manifest.read_text(encoding="utf-8"))["files"]
    except (OSError, ValueError, KeyError):
        return
    for name in listed:
        path = (folder / name).resolve()
        if path.is_relative_to(folder.resolve()):
            path.unlink(missing_ok=True)
    manifest.unlink()
    records = folder / RECORDS
    if records.is_dir() and not any(records.iterdir()):
        shutil.rmtree(records)
