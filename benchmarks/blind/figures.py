"""Figures of one solved case: how far the gap shrank, how good the parameters are, how long it took."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.judge import Worth, classify, finds_place
from benchmarks.blind.mapping import change_until_end
from benchmarks.blind.question import Answer, read_answer

FloatArray = NDArray[np.float64]
Json = Mapping[str, Any]  # what json.loads returns

VISIBLE = 0.3
"""Least gap, in noise rms, for a case to count in the headline figures."""
CHAOTIC = "backlash"
_CONSTANTS = frozenset({"exponent", "with_current", "reaction"})
_WAVES = frozenset({"sine", "cosine"})
_DRIFTS = frozenset({"viscous_friction_drift", "torque_constant_drift"})


@dataclass(frozen=True, slots=True, kw_only=True)
class Solved:
    """One solved case.

    Attributes:
        gap: least gap of the hidden effects, in noise rms; infinite with nothing hidden.
        shrink: gap of the recalibrated base over that of the last model, noise-free; None unless rightly named.
        errors: relative errors of the true parameters, by name.
        covered: whether the 95 % interval holds the truth, by name.
        found_place: `unknown` with the right port and driver.
        seconds: wall time and CPU time; None for the first case of a process, which loads compiled code.
    """

    answer: Answer
    verdict: str
    added: tuple[str, ...]
    worth: Worth
    gap: float
    shrink: float | None
    errors: Mapping[str, float]
    covered: Mapping[str, bool]
    found_place: bool
    seconds: tuple[float, float] | None

    @property
    def visible(self) -> bool:
        """Whether every hidden effect can be seen."""
        return self.gap >= VISIBLE


def read_solved(answer_path: Path, verdict_path: Path) -> Solved:
    """Open the answer of a case and judge its verdict."""
    answer, clean = read_answer(answer_path)
    verdict = json.loads(verdict_path.with_suffix(".json").read_text(encoding="utf-8"))
    worth = classify(answer.hidden, verdict)
    right = worth is Worth.RIGHT and verdict["verdict"] == "named"
    errors, covered = parameter_errors(answer, verdict) if right else ({}, {})
    timed = verdict.get("order_in_worker", 0) > 0
    return Solved(
        answer=answer,
        verdict=verdict["verdict"],
        added=tuple(step["added"] for step in verdict["steps"] if step["added"] is not None),
        worth=worth,
        gap=min(answer.gap.values(), default=float("inf")),
        shrink=gap_shrink(answer, clean, verdict_path.with_suffix(".npz")) if right else None,
        errors=errors,
        covered=covered,
        found_place=finds_place(answer.hidden, verdict),
        seconds=(verdict["wall_seconds"], verdict["cpu_seconds"]) if timed else None,
    )


def gap_shrink(answer: Answer, clean: FloatArray, path: Path) -> float | None:
    """Return by what factor the named effects shrank the gap to the noise-free test output.

    Play makes a long free run chaotic, so there both models are simulated anew every second.
    """
    if not path.exists():
        return None
    with np.load(path) as curves:
        suffix = "_windows" if CHAOTIC in answer.hidden else ""
        if f"after{suffix}" not in curves.files:
            return None
        left = [_distance(curves[name + suffix], clean) for name in ("before", "after")]
    return left[0] / left[1] if left[1] > 0.0 else None


def _distance(simulated: FloatArray, clean: FloatArray) -> float:
    difference = simulated - clean
    return float(np.sqrt(np.mean(difference[np.isfinite(difference)] ** 2)))


def parameter_errors(answer: Answer, verdict: Json) -> tuple[dict[str, float], dict[str, bool]]:
    """Return relative errors and coverage of the hidden effects' parameters, where truth and name agree.

    Errors of the two parts of a wave count relative to its amplitude.
    """
    errors: dict[str, float] = {}
    covered: dict[str, bool] = {}
    estimates = {term["id"]: term["parameters"] for term in verdict.get("extended", [])}
    for effect, truth in answer.truth.items():
        found = estimates.get(effect, {})
        amplitude = float(np.hypot(truth.get("sine", 0.0), truth.get("cosine", 0.0)))
        for name, true in truth.items():
            size = amplitude if name in _WAVES else abs(true)
            if name in _CONSTANTS or name not in found or size == 0.0:
                continue
            far = abs(found[name]["value"] - true)
            errors[f"{effect}.{name}"] = far / size
            if found[name].get("std"):
                covered[f"{effect}.{name}"] = far <= 1.96 * found[name]["std"]
    for effect, derived in answer.derived.items():
        if effect in _DRIFTS and effect in estimates and derived:
            values = estimates[effect]
            reached = change_until_end(values["change"]["value"], values["time_constant"]["value"])
            true = derived["change_until_end"]
            errors[f"{effect}.change_until_end"] = abs(reached - true) / abs(true)
    return errors, covered
