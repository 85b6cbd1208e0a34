"""The folder of a fleet: a folder for each joint, and fleet.json, fleet.csv, fleet.html about all of them."""

import csv
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from server.services.fleet_list import FleetJoint
from server.services.joint_job import PLOTLY_NAME, JointAnswer

SCHEMA = "jointscope.fleet/1"
ENTRY_NAME = "joint.json"
"""Written last: a joint without it is not finished."""
CSV_COLUMNS = (
    "joint", "verdict", "effects", "equivalents", "gap_before", "gap_after", "gap_closed", "parameter_changes",
    "open_question", "cpu_s", "error", "report",
)  # fmt: skip
VERDICTS = ("named", "none", "unknown", "error", "waiting")

Entry = Mapping[str, Any]  # Any: values of a JSON object


class FleetFolder:
    """Knows which joints are finished, and writes answers and summaries."""

    def __init__(self, folder: Path, joints: Sequence[FleetJoint]) -> None:
        self._folder, self._joints = folder, joints
        folder.mkdir(parents=True, exist_ok=True)

    def is_finished(self, joint: FleetJoint) -> bool:
        """Say whether there is an answer to the same files, by the same version of this program."""
        entry = self._read(joint)
        return entry is not None and entry["error"] is None and entry["inputs"] == fingerprint(joint)

    def write_joint(self, joint: FleetJoint, answer: JointAnswer) -> None:
        """Write what came of a joint; what an earlier call left in its folder goes."""
        folder = self._folder / joint.joint
        folder.mkdir(exist_ok=True)
        (folder / ENTRY_NAME).unlink(missing_ok=True)
        for name in {"gap.json", "model.yaml", "report.html", "next_campaign.yaml"} - answer.files.keys():
            (folder / name).unlink(missing_ok=True)
        for name, content in answer.files.items():
            (folder / name).write_bytes(content)
        entry = {**answer.entry, "inputs": fingerprint(joint)}
        _write_whole(folder / ENTRY_NAME, json.dumps(entry, indent=1) + "\n")

    def write_summary(self) -> dict[str, int]:
        """Write fleet.json, fleet.csv and fleet.html; returns how many joints have which verdict."""
        from plotly.offline import get_plotlyjs

        from server.reports.fleet_page import render_fleet

        entries = [self._entry(joint) for joint in self._joints]
        counts = Counter(entry["verdict"] for entry in entries)
        ordered = {name: counts[name] for name in VERDICTS}
        content = {
            "schema": SCHEMA,
            "version": version("jointscope"),
            "counts": ordered,
            "cpu_s": round(sum(entry.get("cpu_s", 0.0) for entry in entries), 1),
            "joints": entries,
        }
        _write_whole(self._folder / "fleet.json", json.dumps(content, indent=1) + "\n")
        self._write_csv(entries)
        _write_whole(self._folder / "fleet.html", render_fleet(ordered, entries))
        library = self._folder / PLOTLY_NAME
        if not library.exists():
            _write_whole(library, get_plotlyjs())
        return ordered

    def _write_csv(self, entries: Sequence[Entry]) -> None:
        path = self._folder / "fleet.csv.part"
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(CSV_COLUMNS)
            writer.writerows([csv_field(entry.get(column)) for column in CSV_COLUMNS] for entry in entries)
        path.replace(self._folder / "fleet.csv")

    def _entry(self, joint: FleetJoint) -> dict[str, Any]:  # Any: values of a JSON object
        """Return a joint's line of the summary."""
        found = self._read(joint)
        if found is None:
            return {"joint": joint.joint, "verdict": "waiting", "error": None, "report": None}
        found = {name: value for name, value in found.items() if name != "inputs"}
        if found["error"] is not None:
            return {**found, "verdict": "error", "report": None}
        return {**found, "report": f"{joint.joint}/report.html"}

    def _read(self, joint: FleetJoint) -> dict[str, Any] | None:  # Any: values of a JSON object
        try:
            found = json.loads((self._folder / joint.joint / ENTRY_NAME).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return found if isinstance(found, dict) and {"error", "inputs"} <= found.keys() else None


def csv_field(value: object) -> object:
    """Return a value as one field of a table."""
    if isinstance(value, Mapping):
        return "; ".join(f"{name} {before:.6g} -> {after:.6g}" for name, (before, after) in value.items())
    if isinstance(value, list):
        return "; ".join(one if isinstance(one, str) else " with ".join(one) for one in value)
    return value


def fingerprint(joint: FleetJoint) -> list[object]:
    """Return what changes when a joint has to be done again: its files, or this program."""
    found: list[object] = [version("jointscope")]
    for path in joint.files:
        try:
            status = path.stat()
            found.append([path.name, status.st_size, status.st_mtime_ns])
        except OSError:
            found.append([path.name, None, None])
    return found


def _write_whole(path: Path, text: str) -> None:
    """Write so that a reader sees the old file or the new one, never half of it."""
    part = path.with_name(path.name + ".part")
    part.write_text(text, encoding="utf-8")
    part.replace(path)
