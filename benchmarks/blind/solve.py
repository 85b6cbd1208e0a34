"""Solve one blind case from its recordings and the nameplate.

`python -m benchmarks.blind.solve DIR [INPUT]` writes DIR/verdict.json.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np

from daq.recording.recording import Recording, recording_from_columns
from discrepancy.model.reader import parse_model
from discrepancy.workflow import run_gap

NAMEPLATE = {
    "name": "emulated joint",
    "axis": "rotary",
    "input": "current_A",
    "outputs": ["speed_rad_s"],
    "parameters": {
        "inertia": {"value": 0.5, "unit": "kg m^2", "fixed": True},
        "viscous_friction": {"value": 0.9, "unit": "N m s/rad"},
        "torque_constant": {"value": 1.0, "unit": "N m/A"},
    },
}


def read_case(folder: Path) -> dict[str, Recording]:
    """Return the recordings of a case by label."""
    found: dict[str, dict[str, np.ndarray]] = {}
    with np.load(folder / "case.npz") as case:
        for key in case.files:
            label, column = key.split("/")
            found.setdefault(label, {})[column] = case[key]
    return {label: recording_from_columns(columns, sample_time_s=4e-4) for label, columns in found.items()}


def main(folder: Path) -> None:
    """Write the verdict of one case."""
    records = read_case(folder)
    train = [record for label, record in records.items() if label.startswith("train")]
    test = [record for label, record in records.items() if label.startswith("test")]
    # Which current drives the model is part of the question: current-port cases are asked from the reference.
    model = parse_model({**NAMEPLATE, "input": sys.argv[2] if len(sys.argv) > 2 else "current_A"})
    start = time.perf_counter()
    result = run_gap(model, train, test)
    verdict = {**result.to_dict(), "seconds": time.perf_counter() - start}
    (folder / "verdict.json").write_text(json.dumps(verdict, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
