"""Has an uploaded file imported by a process of its own, with limits; see `import_child.py`."""

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from server.errors import InputError
from server.services.workers import child_environment

_MODULE = "server.services.recordings.import_child"
_BASE_OCTETS = 1 << 30  # the libraries themselves
_GROWTH = 24  # a CSV file of one digit per value grows by so much, with a copy of it
CPU_S = 600
EXPANSION = 8
"""A compressed file may hold so many times what an upload may have; more is no measurement but a trap."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ImportTask:
    """What the process is told.

    Attributes:
        source, target: files.
        mappings, leave_out, span_s: as in `files.Upload`.
        memory_octets, cpu_s: where the process ends.
        unpacked_octets: what a compressed file may hold.
    """

    source: str
    target: str
    mappings: Sequence[str]
    leave_out: Sequence[str]
    span_s: tuple[float, float] | None
    memory_octets: int
    unpacked_octets: int
    cpu_s: int = CPU_S


def memory_limit(upload_octets: int) -> int:
    """Return what an import may take: enough for the largest upload, and never more than half of this machine."""
    machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return min(_BASE_OCTETS + _GROWTH * upload_octets, max(machine // 2, _BASE_OCTETS))


def run_import(task: ImportTask) -> None:
    """Import a file.

    Raises:
        InputError: no measurement, or one that the limits do not allow; names the file without its folder.
    """
    done = subprocess.run(
        [sys.executable, "-m", _MODULE],
        input=json.dumps(asdict(task)) + "\n",
        capture_output=True,
        text=True,
        check=False,
        env=child_environment(),
    )
    source = Path(task.source)
    try:
        error = json.loads(done.stdout)["error"]
    except ValueError:  # ended without a word: killed by a limit, or crashed by the file
        error = "the importer could not survive it: damaged, or far too large once unpacked"
    if error is not None:
        text = str(error).replace(str(source), source.name)
        raise InputError(text if source.name in text else f"{source.name}: {text}")
