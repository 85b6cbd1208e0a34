"""The JSON form of an identification, schema "jointscope.identification/1" (docs/estimators.md)."""

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from estimators.continuous import ContinuousRefusal
from estimators.dataset import Dataset, Vector
from estimators.metrics import Score
from estimators.result import SCHEMA, IdentificationResult, MethodResult, Mode, Phase

# Series are for plots: more digits would only make the file larger. Parameters keep all digits.
_SERIES_DIGITS = 7
_HISTORY_POINTS = 500


def export_result(result: IdentificationResult) -> dict[str, Any]:  # Any: a JSON object
    """Return the whole result as a JSON object; NaN and inf become null."""
    options = asdict(result.options)
    structure = options.pop("structure")
    document = {
        "schema": SCHEMA,
        "sample_time_s": result.train.sample_time_s,
        "structure": structure,
        "options": options,
        "records": {
            Phase.TRAINING.value: _export_record(result.train),
            Phase.TEST.value: _export_record(result.test),
        },
        "trivial": {phase.value: asdict(score) for phase, score in result.trivial.items()},
        "methods": {name: _describe_method(method) for name, method in result.methods.items()},
        "verdict": list(result.verdict),
        "excitation": asdict(result.excitation),
        "selection": asdict(result.selection) if result.selection else None,
    }
    cleaned: dict[str, Any] = _clean(document)  # Any: a JSON object
    # Long series come clean already; walking them number by number would take longer than identifying.
    cleaned["series"] = {
        Phase.TRAINING.value: _export_samples(result.train),
        Phase.TEST.value: _export_samples(result.test),
    }
    for name, method in result.methods.items():
        cleaned["methods"][name] |= _export_method_series(method)
    return cleaned


def _export_record(dataset: Dataset) -> dict[str, Any]:  # Any: a JSON object
    return {"samples": dataset.n, "segment_starts": list(dataset.starts)}


def _export_samples(dataset: Dataset) -> dict[str, Any]:  # Any: a JSON object
    return {"u": _round(dataset.u), "y": _round(dataset.y)}


def _describe_method(method: MethodResult) -> dict[str, Any]:  # Any: a JSON object
    continuous = method.continuous
    return {
        "title": method.title,
        "parameters": [
            {"name": name, "value": float(value), "std": float(std)}
            for name, value, std in zip(
                method.parameter_names, method.theta, method.standard_errors, strict=True
            )
        ],
        "noise_variance": method.noise_variance,
        "weights": dict(method.weights),
        "transfer_function": {**asdict(method.transfer_function), "text": method.transfer_function.text},
        "poles": [asdict(pole) for pole in method.poles],
        "static_gain": asdict(method.static_gain),
        "simulable": method.model.simulable,
        "continuous": (
            {"refused": continuous.reason}
            if isinstance(continuous, ContinuousRefusal)
            else {
                "numerator": continuous.numerator,
                "denominator": continuous.denominator,
                "dead_time_s": continuous.dead_time_s,
                "poles_rad_s": [{"re": pole.real, "im": pole.imag} for pole in continuous.poles],
                "text": continuous.text,
            }
        ),
        "scores": {phase.value: _export_scores(scores) for phase, scores in method.scores.items()},
        "residuals": asdict(method.residuals),
        "rejected": method.rejected,
        "warnings": list(method.warnings),
        "computing_time_s": method.computing_time_s,
    }


def _export_method_series(method: MethodResult) -> dict[str, Any]:  # Any: a JSON object
    return {
        "series": {
            phase.value: {mode.value: _round(values) for mode, values in series.items()}
            for phase, series in method.series.items()
        },
        "history": _export_history(method),
    }


def _export_scores(scores: Mapping[Mode, Score]) -> dict[str, Any]:  # Any: a JSON object
    return {mode.value: asdict(scores[mode]) if mode in scores else None for mode in Mode}


def _export_history(method: MethodResult) -> dict[str, Any] | None:  # Any: a JSON object
    """Return the parameters' way through training, thinned out for plots."""
    history = method.history
    if history is None:
        return None
    n = history.rows.size
    picks = np.unique(np.linspace(0, n - 1, min(n, _HISTORY_POINTS)).astype(np.int64))
    return {
        "sample": history.rows[picks].tolist(),
        "theta": {name: _round(history.theta[picks, i]) for i, name in enumerate(method.parameter_names)},
    }


def _round(values: Vector) -> list[float | None]:
    """Return a series with as many decimals as its largest value needs; NaN and inf become None."""
    finite = np.isfinite(values)
    largest = float(np.max(np.abs(values[finite]), initial=0.0))
    decimals = _SERIES_DIGITS - (math.ceil(math.log10(largest)) if largest > 0 else 0)
    with np.errstate(all="ignore"):  # inf and NaN pass through and are replaced below
        rounded: list[float | None] = np.round(values, min(decimals, 300)).tolist()
    for index in np.flatnonzero(~finite):
        rounded[index] = None
    return rounded


def _clean(value: Any) -> Any:  # Any: walks a JSON value
    """Replace NaN and inf by None and tuples by lists, all the way down."""
    if isinstance(value, Mapping):
        return {key: _clean(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_clean(item) for item in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return value
