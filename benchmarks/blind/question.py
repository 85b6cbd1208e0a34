"""What a solver gets (`Question`) and what it must not see (`Answer`), as files."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Json = dict[str, Any]  # what json.loads returns

SPEED = "speed_rad_s"
KEEP = 0.004
"""Noise-free truth and simulated curves are kept about every 4 ms: all motion lies below 30 Hz."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Question:
    """Recordings and nameplate model of one case.

    Attributes:
        model: content of a model file.
        records: columns by label; labels begin with `train` or `test`.
        metadata: of every recording, as the driver writes it: how the speed was derived from the position.
    """

    model: Json
    step_s: float
    records: Mapping[str, Mapping[str, FloatArray]]
    metadata: Json = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """What was hidden.

    Attributes:
        hidden: ids, in the catalogue's words where it has them.
        scenario: hidden effects as the physics knows them.
        held: ids that the base model holds.
        truth: by id, true values in the catalogue's names.
        derived: by id, true values of what parameters fix together.
        gap: by id, rms of what this effect alone changes on the test record, in noise rms.
        gap_recalibrated: by id, the same after recalibration.
        gap_total: of all hidden effects together, in noise rms.
        noise_rms: measured minus noise-free test output, rad/s.
    """

    condition: str
    id: str
    seed: int
    hidden: list[str]
    scenario: list[Json]
    held: list[str] = field(default_factory=list)
    truth: dict[str, dict[str, float]] = field(default_factory=dict)
    derived: dict[str, dict[str, float]] = field(default_factory=dict)
    gap: dict[str, float] = field(default_factory=dict)
    gap_recalibrated: dict[str, float] = field(default_factory=dict)
    gap_total: float = 0.0
    noise_rms: float = 0.0
    notes: dict[str, float | str] = field(default_factory=dict)


def stride(step_s: float) -> int:
    """Return every how many samples curves are kept."""
    return max(1, round(KEEP / step_s))


def write_question(question: Question, folder: Path) -> None:
    """Write `question.json` and `records.npz`."""
    folder.mkdir(parents=True, exist_ok=True)
    arrays = {
        f"{label}/{name}": values
        for label, columns in question.records.items()
        for name, values in columns.items()
    }
    np.savez(folder / "records.npz", **arrays)  # type: ignore[arg-type]  # savez takes any array by keyword
    text = json.dumps({"model": question.model, "step_s": question.step_s, "metadata": question.metadata})
    (folder / "question.json").write_text(text, encoding="utf-8")


def read_question(folder: Path) -> Question:
    """Read what `write_question` wrote."""
    head = json.loads((folder / "question.json").read_text(encoding="utf-8"))
    records: dict[str, dict[str, FloatArray]] = {}
    with np.load(folder / "records.npz") as file:
        for key in file.files:
            label, name = key.split("/")
            records.setdefault(label, {})[name] = file[key]
    return Question(**head, records=records)


def write_answer(answer: Answer, clean_test: FloatArray, step_s: float, path: Path) -> None:
    """Write PATH.json and the noise-free test output beside it, PATH.npz."""
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez(path.with_suffix(".npz"), clean=clean_test[:: stride(step_s)])
    path.with_suffix(".json").write_text(json.dumps(asdict(answer), indent=1), encoding="utf-8")


def read_answer(path: Path) -> tuple[Answer, FloatArray]:
    """Read what `write_answer` wrote."""
    content = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    with np.load(path.with_suffix(".npz")) as file:
        return Answer(**content), file["clean"]
