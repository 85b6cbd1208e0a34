"""How well the parameters of a finished model are known, and whose errors another record would make smaller."""

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from discrepancy.design.question import known_errors, relative_errors
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.parameters import NUISANCES
from discrepancy.model.schema import Quantity
from discrepancy.search.outcome import SearchOutcome
from discrepancy.search.standard_errors import form_variances, robust_covariance
from discrepancy.search.state import State

POOR_ERROR = 0.05
"""A parameter whose relative standard error is larger counts as poorly known."""
GOOD_ERROR = POOR_ERROR / math.sqrt(2.0)
"""What an experiment for a poorly known parameter aims at: a standard error is itself an estimate."""


Errors = Mapping[str, float]


def poorly_known(outcome: SearchOutcome, state: State, owner: str, errors: Errors) -> tuple[Errors, Errors]:
    """Return the poorly known parameters of an effect that another record would tell more of, and those none would.

    Noise, and other forms of the law, are what more records settle. The rest of an error is that of laws which are
    nearly right and of the making of the recordings: no motion settles it.

    Args:
        outcome: the finished search.
        state: a model of it.
        owner: id of the effect.
        errors: relative standard errors by name, all parts of them together.
    """
    poor = {name: error for name, error in errors.items() if error > POOR_ERROR}
    if not poor:
        return {}, {}
    squares = np.maximum(0.0, np.diag(robust_covariance(outcome.problem, state.fit, NUISANCES)))
    settled = _settled(state, owner, squares)
    # Other forms only add to the errors, and fitting them is work: what the noise alone leaves open stays open.
    bench = outcome.bench(state) if settled & set(poor) else None
    if bench is not None:
        settled = _settled(state, owner, squares + form_variances(bench, outcome.ranges))
    asked = {name: error for name, error in poor.items() if name not in settled}
    return asked, {name: error for name, error in poor.items() if name in settled}


def _settled(state: State, owner: str, squares: NDArray[np.float64]) -> set[str]:
    """Return the parameters of an effect that are known well where errors have these squares, shape (p,)."""
    fit, spread = state.fit, np.sqrt(squares)
    own = {p.name: float(e) for p, e in zip(fit.parameters, spread, strict=True) if p.owner == owner}
    values = {p.name: float(fit.vector[p.slot]) for p in EFFECTS[owner].parameters}
    return {name for name, error in relative_errors(values, own).items() if error <= POOR_ERROR}


def beyond_motion(outcome: SearchOutcome, values: Mapping[tuple[str, str], Quantity]) -> list[str]:
    """Return a sentence for each parameter that is known poorly though no motion would tell more of it."""
    if outcome.is_torque:
        return []
    last, errors = outcome.steps[-1].state, known_errors(values)
    return [
        f"{name} of {owner} is known to {100 * error:.0f} % only; what is left of its error is not noise but that of "
        "the laws' form and of the recordings' making: no further motion would settle it"
        for owner in last.added
        for name, error in sorted(poorly_known(outcome, last, owner, errors.get(owner, {}))[1].items())
    ]
