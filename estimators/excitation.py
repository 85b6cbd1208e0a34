"""Whether the data can determine the parameters at all: excitation, conditioning, collinearity."""

from dataclasses import dataclass

import numpy as np

from estimators.dataset import Dataset
from estimators.regressors import Regression

_MAX_EXCITATION_ORDER = 20
# An input counts as exciting of order n while the weakest direction of [u(k-1)..u(k-n)] has at least this
# share of the power of the strongest one: 1e-3 of its amplitude.
_POWER_SHARE = 1e-6
# D. A. Belsley, E. Kuh, R. E. Welsch, Regression Diagnostics, 1980: 30 is strong, 100 severe collinearity.
_STRONG_CONDITION = 30.0
# Components of the weakest direction above this share of the largest one take part in the collinearity.
_TAKES_PART = 0.2


@dataclass(frozen=True, slots=True, kw_only=True)
class ExcitationReport:
    """How well the training data can tell the parameters apart.

    Attributes:
        persistent_excitation_order: largest n for which n past inputs are not (almost) linearly dependent;
            a model with nb input terms needs nb, an ARX model without feedback na + nb for free of bias fits.
        required_order: na + nb.
        eigenvalue_ratios: smallest over largest eigenvalue of the input's covariance, for orders 1, 2, ...
        condition_number: of the regressors with columns of unit length.
        weakest_direction: unit vector in the space of scaled parameters that the data see least, by name.
        collinear: names of the parameters that trade against each other; empty if well conditioned.
        weak_directions: combinations of parameters that the data hardly see.
        determined: if there is one such combination, what the data do determine of its parameters, as text.
        sentences: the same for a reader.
    """

    persistent_excitation_order: int
    required_order: int
    eigenvalue_ratios: tuple[float, ...]
    condition_number: float
    weakest_direction: dict[str, float]
    collinear: tuple[str, ...]
    weak_directions: int
    determined: tuple[str, ...]
    sentences: tuple[str, ...]


def report_excitation(dataset: Dataset, regression: Regression) -> ExcitationReport:
    """Examine the input of a data set and the regressors built from it."""
    structure = regression.structure
    names = structure.parameter_names[: structure.n_phi]
    ratios = _find_eigenvalue_ratios(dataset)
    order = _count_excitation(ratios)
    length = np.linalg.norm(regression.phi, axis=0)
    silent = [name for name, value in zip(names, length, strict=True) if value == 0.0]
    scaled = regression.phi / np.where(length > 0, length, 1.0)
    _, singular, right = np.linalg.svd(scaled, full_matrices=False)
    condition = float(singular[0] / singular[-1]) if singular[-1] > 0 else float("inf")
    weakest = right[-1] * np.sign(right[-1][np.argmax(np.abs(right[-1]))])
    weak = right[singular * _STRONG_CONDITION < singular[0]]
    involved = np.any(
        np.abs(weak) >= _TAKES_PART * np.max(np.abs(weak), axis=1, initial=0, keepdims=True), axis=0
    )
    collinear = tuple(name for name, part in zip(names, involved, strict=True) if part)
    # theta = scaled theta / length: what the data see of a pair is orthogonal to the one weak direction.
    direction = weakest[involved] / np.where(length > 0, length, 1.0)[involved]
    determined = _write_combinations(collinear, direction) if len(weak) == 1 else ()
    return ExcitationReport(
        persistent_excitation_order=order,
        required_order=structure.n_phi,
        eigenvalue_ratios=ratios,
        condition_number=condition,
        weakest_direction={name: float(value) for name, value in zip(names, weakest, strict=True)},
        collinear=collinear,
        determined=determined,
        weak_directions=len(weak),
        sentences=(
            *_say_excitation(order, structure.n_phi),
            *_say_conditioning(condition, collinear, determined, len(weak)),
            *(f"The regressor of {name} is zero throughout: nothing is known of it." for name in silent),
        ),
    )


def _find_eigenvalue_ratios(dataset: Dataset) -> tuple[float, ...]:
    """Return smallest over largest eigenvalue of the covariance of n neighbouring inputs, n = 1, 2, ..."""
    ratios = []
    for order in range(1, _MAX_EXCITATION_ORDER + 1):
        pieces = [
            np.lib.stride_tricks.sliding_window_view(dataset.u[s], order)
            for s in dataset.segments
            if s.stop - s.start >= order
        ]
        rows = sum(piece.shape[0] for piece in pieces)
        if rows < order:
            break
        moments = sum((piece.T @ piece for piece in pieces), np.zeros((order, order)))
        eigenvalues = np.linalg.eigvalsh(moments)
        ratios.append(float(max(eigenvalues[0], 0.0) / eigenvalues[-1]) if eigenvalues[-1] > 0 else 0.0)
        if ratios[-1] < _POWER_SHARE:
            break
    return tuple(ratios)


def _count_excitation(ratios: tuple[float, ...]) -> int:
    return sum(ratio >= _POWER_SHARE for ratio in ratios)


def _write_combinations(names: tuple[str, ...], direction: np.ndarray) -> tuple[str, ...]:
    """Write, for each pair with the strongest parameter, the combination that the weak direction spares."""
    if len(names) < 2:
        return ()
    lead = int(np.argmax(np.abs(direction)))
    texts = []
    for i, name in enumerate(names):
        if i == lead:
            continue
        weight = -float(direction[i] / direction[lead])
        sign = "-" if weight < 0 else "+"
        size = "" if abs(abs(weight) - 1.0) < 0.02 else f"{abs(weight):.3g} "
        texts.append(f"{name} {sign} {size}{names[lead]}")
    return tuple(texts)


def _say_excitation(order: int, required: int) -> tuple[str, ...]:
    reached = f"at least {order}" if order == _MAX_EXCITATION_ORDER else f"{order}"
    if order >= required:
        return (f"The input is persistently exciting of order {reached}; the model asks for {required}.",)
    return (
        f"The input is persistently exciting of order {reached}; the model asks for {required}: use an input "
        "with more frequencies (multisine, PRBS, trapezoid), or a lower order.",
    )


def _say_conditioning(
    condition: float, collinear: tuple[str, ...], determined: tuple[str, ...], weak: int
) -> tuple[str, ...]:
    if not weak:
        return (f"The regressors' condition number is {condition:.3g}: the parameters can be told apart.",)
    opening = (
        f"The regressors of {', '.join(collinear)} are nearly collinear (condition number {condition:.3g}): "
    )
    if determined:
        return (
            f"{opening}of these parameters only {' and '.join(determined)} is determined well, "
            "not each one by itself.",
        )
    return (f"{opening}{weak} combinations of these parameters are hardly determined.",)
