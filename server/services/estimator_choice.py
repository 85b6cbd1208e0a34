"""Which estimators with which options: what cannot be meant is refused before anything is recorded for it.

One identification has one set of options for all its estimators (`IdentifyOptions`). A session's request gives them
estimator by estimator, so two estimators could be promised different values; that is refused instead of being settled
silently by the last one. Ranges are not repeated here: each estimator is prepared once on a few made-up rows, and says
itself what it does not take.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from estimators.dataset import Dataset
from estimators.regressors import build_regression
from estimators.settings import IdentifyOptions
from estimators.table import RecursiveSpec, find_estimator
from server.services.errors import InvalidValueError
from server.services.identification import tuned_options

SHARED = ("max_lag",)  # of the report, not of an estimator
_PROBE_ROWS = 64


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimatorChoice:
    """One estimator with the options that were given to it."""

    name: str
    options: Mapping[str, float] = field(default_factory=dict)


def check_choices(choices: Sequence[EstimatorChoice]) -> dict[str, float]:
    """Return the options of an identification with these estimators.

    Raises:
        InvalidValueError: an estimator or option that does not exist, stands twice, is out of range, or contradicts
            another one; `field` is `estimators.INDEX.name` or `estimators.INDEX.options.NAME`.
    """
    for index, choice in enumerate(choices):
        _check_name(index, choice, choices)
        for name, value in choice.options.items():
            _check_option(f"estimators.{index}.options.{name}", choice.name, name, value)
    merged: dict[str, float] = {}
    for choice in choices:
        merged |= choice.options
    for index, choice in enumerate(choices):
        _check_agreement(index, choice, merged)
    return merged


def check_option_for(methods: Sequence[str], name: str, value: float) -> None:
    """Refuse an option that none of these estimators takes, or a value that one of them does not take.

    Raises:
        ValueError: the message says what is allowed.
    """
    takers = [method for method in methods if name in _options_of(method)]
    for method in takers or methods[:1]:
        _check_option("options", method, name, value)


def check_length(
    rows: int, *, order: int, delay: int, methods: Sequence[str], options: Mapping[str, float]
) -> None:
    """Refuse a record that gives fewer rows than the richest model has parameters.

    Args:
        rows: samples of the record at the models' sample time.
        order: of the models.
        delay: of the models, in samples.
        methods: names of the estimators.
        options: of the identification.

    Raises:
        ValueError: the message says how many rows are needed.
    """
    plain = IdentifyOptions(order=order, delay=delay, methods=tuple(methods)).structure
    noise = int(options.get("residual_terms", 1)) if "erls" in methods else 0
    needed = plain.reach + plain.n_parameters + noise + 1
    if rows < needed:
        raise ValueError(
            f"gives {rows} rows, and a model of order {order} with delay {delay} needs at least {needed}"
        )


def _check_name(index: int, choice: EstimatorChoice, choices: Sequence[EstimatorChoice]) -> None:
    where = f"estimators.{index}.name"
    try:
        find_estimator(choice.name)
    except ValueError as error:
        raise InvalidValueError(
            str(error), field=where, value=choice.name, remedy="use one of these"
        ) from error
    if any(earlier.name == choice.name for earlier in choices[:index]):
        raise InvalidValueError(
            f"estimator {choice.name!r} stands twice",
            field=where,
            value=choice.name,
            remedy="name it once; for other options make another session",
        )


def _check_option(where: str, estimator: str, name: str, value: float) -> None:
    try:
        tuned = tuned_options({name: value})
    except ValueError as error:
        raise InvalidValueError(
            str(error), field=where, value=value, remedy="see docs/estimators.md"
        ) from error
    taken = _options_of(estimator)
    if name not in taken:
        raise InvalidValueError(
            f"option {name!r} means nothing to the estimator {estimator}",
            field=where,
            value=value,
            remedy=f"leave it out; {estimator} takes {', '.join(taken)}",
        )
    spec = find_estimator(estimator)
    try:
        options = IdentifyOptions(methods=(estimator,), **tuned)
        if isinstance(spec, RecursiveSpec):
            spec.prepare(build_regression(_probe(), options.structure), options)
    except ValueError as error:
        words, _, remedy = str(error).partition("; ")
        raise InvalidValueError(
            words, field=where, value=value, remedy=remedy or "give a value in that range"
        ) from error


def _check_agreement(index: int, choice: EstimatorChoice, merged: Mapping[str, float]) -> None:
    for name, value in merged.items():
        if name in SHARED and name not in choice.options:
            continue
        if name in _options_of(choice.name) and choice.options.get(name) != value:
            given = choice.options.get(name)
            has = "does not give it" if given is None else f"gives {given:g}"
            raise InvalidValueError(
                f"one identification has one {name}: another estimator gives {value:g}, {choice.name} {has}",
                field=f"estimators.{index}.options.{name}",
                value=given,
                remedy=f"give {choice.name} {name}={value:g} as well, or make another session for it",
            )


def _options_of(estimator: str) -> tuple[str, ...]:
    return (*find_estimator(estimator).takes, *SHARED)


def _probe() -> Dataset:
    """Return rows on which an estimator can be prepared; nothing is learnt from them."""
    u = np.random.default_rng(0).standard_normal(_PROBE_ROWS)
    return Dataset(u=u, y=np.convolve(u, [0.0, 0.5, 0.2])[:_PROBE_ROWS], sample_time_s=1.0, starts=(0,))
