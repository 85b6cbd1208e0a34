"""Identify a joint from two recordings and write `identification.json`; `server.reports` makes the report."""

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from estimators.regressors import build_regression
from estimators.settings import IdentifyOptions
from estimators.table import RecursiveSpec, find_estimator
from server.errors import InputError, InputLocation
from server.services.dataset import PreparedData, Signals, prepare_data

if TYPE_CHECKING:
    from estimators.result import IdentificationResult

JSON_NAME = "identification.json"
DEFAULT_METHODS = ("rls", "erls", "rls_kf")
# Options of `IdentifyOptions` that a user may set, and what they are made of.
TUNABLE: Mapping[str, type[int] | type[float] | type[bool]] = {
    "residual_terms": int,
    "forgetting": float,
    "directional_forgetting": float,
    "reset_interval": int,
    "rw": float,
    "rv": float,
    "start_near_zero": bool,
    "max_lag": int,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class IdentifyRequest:
    """What to identify.

    Attributes:
        train: recording to learn from.
        test: recording that only scores.
        sample_time_s: sample time of the models.
        order: past outputs and inputs of the models.
        delay: samples between the input and its first effect.
        methods: names in `estimators.table.ESTIMATORS`.
        options: further options of the estimators by name, see `TUNABLE`.
        signals: input and output columns.
    """

    train: Path
    test: Path
    sample_time_s: float = 0.2
    order: int = 2
    delay: int = 1
    methods: tuple[str, ...] = DEFAULT_METHODS
    options: Mapping[str, float] = field(default_factory=dict)
    signals: Signals = Signals()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Identification:
    """A finished identification, with the data that it came from.

    Attributes:
        result: the comparison of all estimators.
        train, test: the data that were used, at the models' sample time.
        json_path: where identification.json was written.
    """

    result: "IdentificationResult"
    train: PreparedData
    test: PreparedData
    json_path: Path


def run_identification(request: IdentifyRequest, out: Path, tell: Callable[[str], None]) -> Identification:
    """Read both recordings, compare the estimators and write identification.json.

    Args:
        request: what to identify.
        out: folder for identification.json.
        tell: takes lines for the user; the first estimate comes as soon as the training recording is read.

    Raises:
        InputError: wrong options or recordings that cannot be used.
    """
    options = make_options(request)
    train = prepare_data(request.train, request.signals, request.sample_time_s)
    tell(first_estimate(train, options))
    from estimators.identify import identify  # the first estimate does not wait for what only the others need

    # The test recording must be read as the training one was, so that both have the same input.
    signals = Signals(input=train.input[0], output=train.output[0])
    test = prepare_data(request.test, signals, request.sample_time_s)
    for name, data in (("train", train), ("test", test)):
        tell(f"{name}: {data.source.name}: {'; '.join(data.notes)}")
    try:
        result = identify(train.dataset, test.dataset, options, clock=time.perf_counter)
    except ValueError as error:
        raise InputError(str(error), InputLocation(source=request.train)) from error
    out.mkdir(parents=True, exist_ok=True)
    path = out / JSON_NAME
    document = {**result.to_dict(), "data": {"train": describe_data(train), "test": describe_data(test)}}
    path.write_text(json.dumps(document, allow_nan=False) + "\n", encoding="utf-8")
    return Identification(result=result, train=train, test=test, json_path=path)


def make_options(request: IdentifyRequest) -> IdentifyOptions:
    """Return the estimators' options.

    Raises:
        InputError: a value that no estimator takes.
    """
    try:
        for method in request.methods:
            find_estimator(method)
        return IdentifyOptions(
            order=request.order,
            delay=request.delay,
            methods=request.methods,
            **tuned_options(request.options),
        )
    except ValueError as error:
        raise InputError(str(error)) from error


def tuned_options(options: Mapping[str, float]) -> dict[str, Any]:  # Any: each has the type that TUNABLE says
    """Return estimator options with their proper types.

    Raises:
        ValueError: an option that does not exist, or a fraction where a whole number is needed.
    """
    tuned: dict[str, Any] = {}  # Any: the same
    for name, value in options.items():
        if name not in TUNABLE:
            raise ValueError(f"option {name!r} does not exist; allowed: {', '.join(TUNABLE)}")
        tuned[name] = TUNABLE[name](value)
        if tuned[name] != value:
            raise ValueError(f"option {name}={value:g} must be of type {TUNABLE[name].__name__}")
    return tuned


def first_estimate(train: PreparedData, options: IdentifyOptions) -> str:
    """Return one line with the first estimator's parameters on the training data."""
    name = options.methods[0]
    spec = find_estimator(name)
    try:
        if not isinstance(spec, RecursiveSpec):
            theta = spec.fit(train.dataset, options).theta
        else:
            regression = build_regression(train.dataset, options.structure)
            estimator = spec.prepare(regression, options)
            state = estimator.init()
            for bound in regression.bounds:
                state.begin_segment()
                estimator.run(state, regression.phi[bound], regression.y[bound], keep_history=False)
            theta = state.theta
    except ValueError as error:
        raise InputError(str(error), InputLocation(source=train.source)) from error
    values = "  ".join(f"{value:.6g}" for value in theta)
    return f"first estimate, {spec.title}: theta = [{values}]"


def describe_data(data: PreparedData) -> Mapping[str, object]:
    """Return where data came from and what was done to it, as JSON values."""
    return {
        "file": str(data.source),
        "input": {"column": data.input[0], "unit": data.input[1]},
        "output": {"column": data.output[0], "unit": data.output[1]},
        **data.facts,
    }
