"""Reads one uploaded file as a process of its own: `python -m server.services.recordings.import_child`.

What strangers send meets parsers written in C here and nowhere else: a file that makes one of them crash, or eat all
memory, ends this process and not the service. The request is a line of JSON on stdin, the answer one on stdout:
{"error": null}, or the sentence that the user is told.
"""

import json
import resource
import sys
from pathlib import Path
from shutil import copyfile
from typing import Any

from daq.exchange.importing import import_file, load_recording
from daq.exchange.mapping import parse_mappings
from daq.recording.recording import Recording, cut
from daq.recording.store import publish, write_recording
from server.services.recordings.inspection import inspect_file


def main() -> None:
    """Import a file, or tell why not."""
    asked = json.loads(sys.stdin.readline())
    _limit(resource.RLIMIT_DATA, asked["memory_octets"])
    _limit(resource.RLIMIT_CPU, asked["cpu_s"])
    try:
        _import(asked)
        error = None
    except MemoryError:
        error = "it needs more memory than an upload may take; split it"
    # Whatever a stranger's file makes the readers raise is a fault of the file, and none of ours.
    except Exception as raised:  # noqa: BLE001
        error = str(raised) or type(raised).__name__
    sys.stdout.write(json.dumps({"error": error}) + "\n")


def _import(asked: dict[str, Any]) -> None:  # JSON values
    source, target = Path(asked["source"]), Path(asked["target"])
    inspect_file(source, asked["unpacked_octets"])
    mappings, leave_out = parse_mappings(asked["mappings"]), tuple(asked["leave_out"])
    plain = not mappings and not leave_out
    recording = load_recording(source) if plain else import_file(source, mappings, leave_out=leave_out)
    for name in recording.columns:
        recording.column(name)  # a damaged column is refused here, and not by whoever asks for it first
    if asked["span_s"] is not None:
        recording = cut(recording, *asked["span_s"])
    if plain and asked["span_s"] is None and _is_ours(recording, source):
        partial = target.with_name(target.name + ".partial")
        copyfile(source, partial)
        publish(partial, target)
    else:
        write_recording(recording, target)


def _is_ours(recording: Recording, source: Path) -> bool:
    """Tell whether a file holds raw counts with their calibration, which are kept as they are."""
    return source.suffix == ".parquet" and "calibration" in recording.metadata


def _limit(what: int, value: int) -> None:
    hard = resource.getrlimit(what)[1]
    allowed = value if hard == resource.RLIM_INFINITY else min(value, hard)
    resource.setrlimit(what, (allowed, hard))


if __name__ == "__main__":
    main()
