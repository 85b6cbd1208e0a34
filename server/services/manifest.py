"""The manifest of a run folder: what was asked for, with what, what happened, and the files' hashes.

It is rewritten after every step, atomically, so that a run that is killed leaves a manifest that says how far
it came.
"""

import hashlib
import json
import platform
import subprocess
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from enum import StrEnum
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

SCHEMA = "jointscope.run/1"
MANIFEST_NAME = "manifest.json"
PACKAGES = ("jointscope", "numpy", "scipy", "numba", "pyarrow", "pyserial", "cobs")


class Ended(StrEnum):
    """How a step or a run ended."""

    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"
    REFUSED = "refused"
    TRIPPED = "tripped"
    INTERRUPTED = "interrupted"
    NOT_STARTED = "not started"


@dataclass(slots=True, kw_only=True)
class StepEntry:
    """One step of the run; filled in as it proceeds.

    Attributes:
        index: place in the campaign, from 0.
        kind: record, identify, gap, wait or set.
        title: what it was about, for people.
        started, ended_at: UTC, ISO 8601; None before.
        ended: how it ended.
        message: why, when it did not end well.
        files: paths in the run folder that it wrote.
        figures: numbers worth keeping (samples, lost samples, wire use).
    """

    index: int
    kind: str
    title: str
    started: str | None = None
    ended_at: str | None = None
    ended: Ended = Ended.NOT_STARTED
    message: str = ""
    files: list[str] = field(default_factory=list)
    figures: dict[str, object] = field(default_factory=dict)


@dataclass(slots=True, kw_only=True)
class Manifest:
    """What stands in manifest.json.

    Attributes:
        campaign: file, text and SHA-256 of the campaign.
        rig: name, file, text and SHA-256 of the rig file, and what the controller said of itself.
        steps: one entry for each step of the campaign.
        started, ended_at, ended, message: as for a step, of the whole run.
        operator: from the campaign file.
    """

    campaign: Mapping[str, object]
    rig: dict[str, object]
    steps: list[StepEntry]
    started: str
    operator: str = ""
    ended_at: str | None = None
    ended: Ended = Ended.RUNNING
    message: str = ""

    def write(self, folder: Path) -> Path:
        """Write manifest.json with the hashes of all files in the run folder; replaces the last one whole."""
        content = {
            "schema": SCHEMA,
            **asdict(self),
            "versions": versions(),
            "host": {"system": platform.platform(), "python": platform.python_version()},
            "git": git_identity(),
            "files": hash_files(folder),
        }
        target = folder / MANIFEST_NAME
        draft = folder / f".{MANIFEST_NAME}.draft"
        draft.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        draft.replace(target)
        return target


def now() -> str:
    """Return the time of day in UTC, ISO 8601, to the millisecond."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def describe_source(path: Path) -> dict[str, object]:
    """Return an input file's path, text and hash, so that a run can be repeated without the file."""
    text = path.read_text(encoding="utf-8")
    return {"file": str(path), "sha256": hashlib.sha256(text.encode()).hexdigest(), "text": text}


def hash_files(folder: Path) -> dict[str, dict[str, object]]:
    """Return size and SHA-256 of every file below a run folder but its manifest."""
    return {
        str(path.relative_to(folder)): {"octets": path.stat().st_size, "sha256": _sha256(path)}
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not path.name.endswith((MANIFEST_NAME, ".draft"))
    }


def versions() -> dict[str, str]:
    """Return the versions of this program and of the libraries that touch the numbers."""
    found = {}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "unknown"
    return found


def git_identity() -> dict[str, object] | None:
    """Return commit and state of the working tree this program runs from, None outside a repository."""
    here = Path(__file__).resolve().parent
    try:
        commit = _git(here, "rev-parse", "HEAD")
        return {
            "commit": commit,
            "modified": bool(_git(here, "status", "--porcelain", "--untracked-files=no")),
        }
    except (OSError, subprocess.SubprocessError):
        return None


def _git(folder: Path, *arguments: str) -> str:
    command = ["git", "-C", str(folder), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=10)
    return done.stdout.strip()


def _sha256(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
