"""An identified model as a difference equation, and its one-step and free-run outputs.

y(k) + a_1 y(k-1) + ... = b_0 u(k-delay) + b_1 u(k-delay-1) + ... + e(k) + c_1 e(k-1) + ...
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.dataset import Dataset, Vector
from estimators.kernels.simulation import simulate_difference_equation
from estimators.regressors import build_regression
from estimators.structure import ModelStructure

# A pole this close to the unit circle is on it, as far as numbers printed with a few digits can tell.
_UNIT_CIRCLE_MARGIN = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DiscreteModel:
    """Coefficients of an identified model and their uncertainty.

    Attributes:
        a: a_1..a_na, shape (na,).
        b: b_0..b_(nb-1), shape (nb,).
        c: c_1..c_nc, shape (nc,); empty without residual terms.
        delay: samples between u and its first effect, >= 1.
        covariance: of the vector [a, b, c], square; NaN where unknown.
        sample_time_s: time between samples.
    """

    a: Vector
    b: Vector
    c: Vector
    delay: int
    covariance: NDArray[np.float64]
    sample_time_s: float

    @property
    def structure(self) -> ModelStructure:
        """Orders and delay, without the residual terms."""
        return ModelStructure(na=self.a.size, nb=self.b.size, delay=self.delay)

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Roots of z^na + a_1 z^(na-1) + ..., largest first."""
        roots = np.roots(np.concatenate([[1.0], self.a])).astype(np.complex128)
        return roots[np.argsort(-np.abs(roots), kind="stable")]

    @property
    def simulable(self) -> bool:
        """Whether every pole is inside the unit circle, so that a simulation forgets its start."""
        return bool(np.all(np.isfinite(self.a)) and np.all(np.abs(self.poles) < 1.0 - _UNIT_CIRCLE_MARGIN))


def model_from_theta(
    theta: Vector, covariance: NDArray[np.float64], structure: ModelStructure, sample_time_s: float
) -> DiscreteModel:
    """Split theta into a, b and c (paper, eq. 19 to 25: theta = [a1, a2, b0, b1, c1])."""
    na, n_phi = structure.na, structure.n_phi
    return DiscreteModel(
        a=theta[:na].copy(),
        b=theta[na:n_phi].copy(),
        c=theta[n_phi:].copy(),
        delay=structure.delay,
        covariance=covariance.copy(),
        sample_time_s=sample_time_s,
    )


def shift_by_one(model: DiscreteModel) -> DiscreteModel:
    """Return the model whose regressor is one sample older: what literal Algorithm 1 identifies.

    theta = [a1, a2, b0, b1] then multiplies y(k-2), y(k-3), u(k-delay-1), ...: a becomes [0, a1, a2], the
    delay grows by one, and the denominator is z^3 + a1 z + a2.
    """
    n = model.covariance.shape[0]
    covariance = np.zeros((n + 1, n + 1))
    covariance[1:, 1:] = model.covariance
    return DiscreteModel(
        a=np.concatenate([[0.0], model.a]),
        b=model.b,
        c=model.c,
        delay=model.delay + 1,
        covariance=covariance,
        sample_time_s=model.sample_time_s,
    )


def predict_one_step(model: DiscreteModel, dataset: Dataset) -> Vector:
    """Predict each output from the measured past with the parameters frozen.

    With residual terms the past residuals are those of this prediction, zero before a segment begins.

    Returns:
        Predictions, shape (N,); NaN where a segment has too little past.
    """
    regression = build_regression(dataset, model.structure)
    predicted = np.full(dataset.n, np.nan)
    equation = regression.phi @ np.concatenate([model.a, model.b])
    for bound in regression.bounds:
        rows = regression.rows[bound]
        residual = dataset.y[rows] - equation[bound]
        if model.c.size:
            # e = y - phi' theta - c_1 e(k-1) - ...: the residual of the y and u terms, filtered by 1/C.
            residual = filter_all_pole(residual, model.c)
        predicted[rows] = dataset.y[rows] - residual
    return predicted


def simulate_free_run(model: DiscreteModel, dataset: Dataset) -> Vector:
    """Simulate the output from the input alone, started in each segment from the first measured outputs.

    Returns:
        Simulated outputs, shape (N,); NaN for the samples that start a segment; inf or NaN once a model that
        cannot be simulated has left the range of numbers.
    """
    simulated = np.full(dataset.n, np.nan)
    reach = model.structure.reach
    for segment in dataset.segments:
        out = dataset.y[segment].copy()
        if out.size <= reach:
            continue
        with np.errstate(all="ignore"):  # a diverging model ends in inf, which the score reports
            simulate_difference_equation(model.a, model.b, model.delay, dataset.u[segment].copy(), reach, out)
        out[:reach] = np.nan
        simulated[segment] = out
    return simulated


def filter_all_pole(values: Vector, a: Vector) -> Vector:
    """Filter by 1 / (1 + a_1 q^-1 + ...), from rest."""
    out = np.empty_like(values)
    with np.errstate(all="ignore"):
        simulate_difference_equation(a, np.ones(1), 0, values, 0, out)
    return out
