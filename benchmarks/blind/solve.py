"""Solve blind cases from their recordings and the nameplate, in a process of its own; `serve.py` says how it is asked.

For one by hand: `python -m benchmarks.blind.solve QUESTION_FOLDER VERDICT` writes VERDICT.json and VERDICT.npz (test
speed as the recalibrated base model and the last model simulate it). Nothing here knows an answer.
"""

import json
import sys
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.question import SPEED, Json, Question, read_question, stride
from benchmarks.blind.serve import CountingSolver, serve
from daq.recording.recording import Recording, cut, recording_from_columns
from daq.speed.filters import speed_from_position_zero_phase
from discrepancy.errors import GapInputError
from discrepancy.model.reader import model_to_dict, parse_model
from discrepancy.model.schema import JointModel
from discrepancy.report.files import write_result
from discrepancy.result import GapResult
from discrepancy.simulate import simulate_recording
from discrepancy.workflow import GapOptions, run_gap

FloatArray = NDArray[np.float64]

WINDOWED = frozenset({"backlash", "belt_compliance"})
"""Two masses: chaotic or hardly damped in a long free run, so these are also simulated in windows."""
WINDOW_S = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Records:
    """The recordings of a case."""

    train: list[Recording]
    test: list[Recording]


def recordings(question: Question) -> Records:
    """Return the recordings of a case."""
    found = {
        label: recording_from_columns(columns, sample_time_s=question.step_s, metadata=question.metadata)
        for label, columns in question.records.items()
    }
    return Records(
        train=[one for label, one in found.items() if label.startswith("train")],
        test=[one for label, one in found.items() if label.startswith("test")],
    )


def solve(folder: Path, verdict: Path, order: int = 0) -> None:
    """Write the verdict of one case. Its time is that of reading, search, and writing the report."""
    wall, cpu = time.perf_counter(), time.process_time()
    question = read_question(folder)
    records, model = recordings(question), parse_model(question.model)
    content: Json = {"verdict": "refused", "steps": [], "effects": []}
    result = None
    try:
        result = run_gap(model, records.train, records.test, GapOptions())
    except GapInputError as error:
        content["message"] = str(error)
    if result is not None:
        with tempfile.TemporaryDirectory() as report:
            write_result(result, Path(report))
        content = result.to_dict() | {"extended": model_to_dict(result.model)["effects"]}
    content |= {
        "wall_seconds": time.perf_counter() - wall,
        "cpu_seconds": time.process_time() - cpu,
        "order_in_worker": order,
    }
    verdict.parent.mkdir(parents=True, exist_ok=True)
    if result is not None:
        np.savez(verdict.with_suffix(".npz"), **curves(result, records.test[0]))  # type: ignore[arg-type]  # any array
    # Last, as the mark of a finished case.
    verdict.with_suffix(".json").write_text(json.dumps(content, indent=1), encoding="utf-8")


def curves(result: GapResult, test: Recording) -> dict[str, FloatArray]:
    """Return the simulated test speed `before` and `after`, and both in windows where two masses may be named."""
    every = stride(test.sample_time_s)
    found = {
        name: whole(next(c.simulated for c in result.steps[k].curves if c.name == SPEED), test.n)[::every]
        for name, k in (("before", 0), ("after", -1))
    }
    if WINDOWED & set(result.effects):
        base = with_parameters(result.base_model, result.steps[0].to_dict()["parameters"])
        found["before_windows"] = as_recorded(in_windows(base, test), test)[::every]
        found["after_windows"] = as_recorded(in_windows(result.model, test), test)[::every]
    return found


def whole(speed: FloatArray, n: int) -> FloatArray:
    """Return a speed with NaN at the ends of the record that the answer may have left out, shape (n,)."""
    few = (n - speed.size) // 2
    return np.pad(speed, (few, n - speed.size - few), constant_values=np.nan)


def with_parameters(model: JointModel, values: Mapping[str, Mapping[str, float]]) -> JointModel:
    """Return a model with other values of its base parameters."""
    plain = {name: quantity.value for name, quantity in model.parameters.items()}
    plain |= {name: values[name]["value"] for name in plain if name in values}
    return parse_model(model_to_dict(model) | {"parameters": plain})


def in_windows(model: JointModel, test: Recording) -> FloatArray:
    """Return the speed simulated anew every second, each time from a fitted start, shape (n,)."""
    starts = np.arange(0.0, test.duration_s, WINDOW_S)
    parts = [cut(test, float(a), float(a) + WINDOW_S) for a in starts]
    # A window of a few samples at the end has no motion to start from.
    long = [part for part in parts if part.n > 0.5 * WINDOW_S / test.sample_time_s]
    speeds = [simulate_recording(model, part, "test window").simulated[SPEED] for part in long]
    rest = test.n - sum(part.n for part in long)
    return np.concatenate([*speeds, np.full(rest, np.nan)])


def as_recorded(speed: FloatArray, test: Recording) -> FloatArray:
    """Return a simulated speed made from its angle as the recording's own speed was, shape (n,).

    A motor that runs through its play changes its speed faster than a derived speed shows: unsmoothed, the true model
    itself would stay half the gap away from the noise-free column.
    """
    if "speed" not in test.metadata:
        return speed
    known = np.isfinite(speed)
    angle = np.cumsum(speed[known]) * test.sample_time_s
    found = speed.copy()
    found[known] = speed_from_position_zero_phase(angle, test.sample_time_s)
    return found


if __name__ == "__main__":
    if len(sys.argv) > 1:
        solve(Path(sys.argv[1]), Path(sys.argv[2]))
    else:
        serve(CountingSolver(solve))
