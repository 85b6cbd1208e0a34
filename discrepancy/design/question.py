"""What an experiment is to settle: rivals to tell apart, and parameters of the first of them to measure."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discrepancy.model.schema import Quantity
from discrepancy.search.state import State

FloatArray = NDArray[np.float64]
Quantities = Mapping[tuple[str, str], Quantity]
WAVE_PARTS = ("sine", "cosine")


@dataclass(frozen=True, slots=True, kw_only=True)
class Rival:
    """A fitted model that explains the data as well as others do."""

    name: str
    state: State


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """A parameter that is known too poorly.

    Attributes:
        index: its place among the fitted parameters of the first rival.
        known: relative standard error as the answer gives it.
        goal: wanted relative standard error, less than `known`.
    """

    index: int
    known: float
    goal: float

    def share(self, left: FloatArray) -> FloatArray:
        """Return the reached part of the way, 0 to 1 (and beyond), of the logarithm.

        Args:
            left: standard error over the present one, any shape.
        """
        return np.asarray(-np.log(np.maximum(left, 1e-9)) / math.log(self.known / self.goal))


@dataclass(frozen=True, slots=True, kw_only=True)
class Question:
    """One open question.

    Attributes:
        rivals: the first is taken for the truth whose prediction the others would have to follow.
        needed: distance at which a pair counts as told apart, in noise variances, by the record's length in s and
            the number of the pair.
        wanted: parameters of the first rival to be measured by the same record.
    """

    rivals: tuple[Rival, ...]
    needed: Callable[[float, int], float]
    wanted: tuple[Wanted, ...] = ()


def size_of(name: str, values: Mapping[str, float]) -> float:
    """Return the size that a parameter's error is compared with: of a wave's two parts, the wave's amplitude.

    Args:
        name: of the parameter.
        values: all parameters of the same effect.
    """
    if name in WAVE_PARTS and all(part in values for part in WAVE_PARTS):
        return math.hypot(*(values[part] for part in WAVE_PARTS))
    return abs(values[name])


def relative_errors(values: Mapping[str, float], errors: Mapping[str, float]) -> dict[str, float]:
    """Return the standard errors of an effect's parameters over the sizes that they are compared with."""
    return {name: error / max(size_of(name, values), 1e-12) for name, error in errors.items()}


def known_errors(values: Quantities) -> dict[str, dict[str, float]]:
    """Return relative standard errors by owner and name."""
    found: dict[str, dict[str, float]] = {}
    for owner in dict.fromkeys(owner for owner, _ in values):
        own = {name: q for (who, name), q in values.items() if who == owner}
        errors = {name: q.std for name, q in own.items() if q.std is not None}
        found[owner] = relative_errors({name: q.value for name, q in own.items()}, errors)
    return found


def wanted_of(
    state: State, owner: str, errors: Mapping[str, float], limits: tuple[float, float]
) -> tuple[Wanted, ...]:
    """Return which parameters of an effect are known too poorly.

    The error that an answer gives holds more than noise: a sandwich over few blocks, and how far two weightings are
    apart. How much more it is than the plain one (the ratio of misfit) is taken to stay as it is when records are
    added: what is predicted is the answer's error times what is left of the plain one.

    Args:
        state: the fitted model.
        owner: id of the effect.
        errors: relative standard errors by name, as the answer gives them.
        limits: the largest that will do, and the one to aim at.
    """
    poor, goal = limits
    return tuple(
        Wanted(index=i, known=errors[p.name], goal=goal)
        for i, p in enumerate(state.fit.parameters)
        if p.owner == owner and errors.get(p.name, 0.0) > poor and not at_bound(state, i)
    )


def at_bound(state: State, index: int) -> bool:
    """Return whether a value is pressed against an end of its range other than zero: nothing can be measured of it."""
    parameter = state.fit.parameters[index]
    value = float(state.fit.vector[parameter.slot])
    ends: Sequence[float] = [
        end for end in (parameter.lower, parameter.upper) if math.isfinite(end) and end != 0.0
    ]
    return any(abs(value - end) <= 1e-6 * abs(end) for end in ends)
