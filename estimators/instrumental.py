"""Refined instrumental variables: consistent where least squares is biased by noise on the output."""

import numpy as np
from numpy.typing import NDArray

from estimators.batch_ls import BatchEstimate, solve_least_squares
from estimators.dataset import Dataset, Vector
from estimators.model import DiscreteModel, filter_all_pole, model_from_theta, simulate_free_run
from estimators.regressors import Regression, build_regression
from estimators.settings import IdentifyOptions
from estimators.structure import ModelStructure

_MAX_ITERATIONS = 30
_TOLERANCE = 1e-7
# A relative change below which the iteration counts as settled when it is stopped.
_SETTLED = 1e-3
# Poles of an auxiliary model are mirrored, then kept this far inside the unit circle.
_LARGEST_POLE = 0.9999


def fit_instrumental(dataset: Dataset, options: IdentifyOptions) -> BatchEstimate:
    """Estimate from a data set by refined instrumental variables."""
    return solve_instrumental(dataset, options.structure, _MAX_ITERATIONS)


def solve_instrumental(dataset: Dataset, structure: ModelStructure, max_iterations: int) -> BatchEstimate:
    """Estimate by the refined instrumental variable method with simulated instruments (SRIV).

    Noise on the output makes y(k-1) in the regressor correlate with the equation error, so least squares is
    biased and stays so with any amount of data. Instruments do not: with the noise-free output x = B/A u of
    an auxiliary model in place of y,

        z(k)  = [-x(k-1).. , u(k-d)..]                        instruments
        theta = (sum z_f phi_f')^-1 sum z_f y_f               all of it filtered by 1/A of the last iteration
        cov   = sigma2 (sum z_f z_f')^-1,  sigma2 = mean (y - x)^2

    starting from least squares and repeated until theta stands still. Consistent for any noise that does not
    depend on u, and of least variance for white noise on the output, for which the covariance holds
    (P. C. Young, Recursive Estimation and Time-Series Analysis, 2nd ed. 2011, chapter 7). Not for data
    recorded in closed loop: there the noise does depend on u.

    Args:
        dataset: training data.
        structure: orders and delay.
        max_iterations: where to stop an iteration that does not settle.

    Raises:
        ValueError: If the data hold fewer rows than the model has parameters.
    """
    regression = build_regression(dataset, structure)
    first = solve_least_squares(regression)
    theta = first.theta
    change, least_error, best = np.inf, np.inf, theta
    for _ in range(max_iterations):
        raw = model_from_theta(theta, first.covariance, structure, dataset.sample_time_s)
        model = _stabilise(raw)
        simulated = _simulate(model, dataset)
        error = float(np.mean((dataset.y - simulated) ** 2))
        if raw.simulable and error < least_error:
            least_error, best = error, theta
        z, phi, y = _filter_rows(regression, simulated, dataset, model.a)
        try:
            update = np.asarray(np.linalg.solve(z.T @ phi, z.T @ y), dtype=np.float64)
        except np.linalg.LinAlgError:
            return _give_up(first, "the instruments do not determine the parameters")
        change = float(np.max(np.abs(update - theta) / (np.abs(theta) + np.abs(update) + 1e-12)))
        theta = update
        if not np.all(np.isfinite(theta)):
            return _give_up(first, "the iteration left the range of numbers")
        if change < _TOLERANCE:
            break
    # An iteration that does not settle ends anywhere; its best model by free run is the one to have.
    return _conclude(theta if change < _SETTLED else best, change, regression, dataset, first)


def _conclude(
    theta: Vector, change: float, regression: Regression, dataset: Dataset, first: BatchEstimate
) -> BatchEstimate:
    """Return theta with its covariance, from instruments of the final model."""
    raw = model_from_theta(theta, first.covariance, regression.structure, dataset.sample_time_s)
    model = _stabilise(raw)
    simulated = _simulate(model, dataset)
    z, _, _ = _filter_rows(regression, simulated, dataset, model.a)
    error = (dataset.y - simulated)[regression.rows]
    noise_variance = float(np.sum(error**2) / max(error.size - theta.size, 1))
    notes = []
    if change >= _SETTLED:
        notes.append(
            "the iteration did not settle; this is its best model by free run on the training record"
        )
    if not raw.simulable:
        notes.append("the model cannot be simulated; its instruments came from a stabilised copy")
    return BatchEstimate(
        theta=theta,
        covariance=np.asarray(noise_variance * np.linalg.pinv(z.T @ z, hermitian=True), dtype=np.float64),
        noise_variance=noise_variance,
        notes=tuple(notes),
    )


def _simulate(model: DiscreteModel, dataset: Dataset) -> Vector:
    """Return the free run with the measured outputs where a segment starts."""
    simulated = simulate_free_run(model, dataset)
    return np.where(np.isnan(simulated), dataset.y, simulated)


def _filter_rows(
    regression: Regression, simulated: Vector, dataset: Dataset, a: Vector
) -> tuple[NDArray[np.float64], NDArray[np.float64], Vector]:
    """Return instruments, regressors and outputs filtered by 1/A, segment by segment."""
    clean = Dataset(u=dataset.u, y=simulated, sample_time_s=dataset.sample_time_s, starts=dataset.starts)
    instruments = build_regression(clean, regression.structure).phi
    z, phi, y = np.empty_like(instruments), np.empty_like(instruments), np.empty_like(regression.y)
    for bound in regression.bounds:
        y[bound] = filter_all_pole(regression.y[bound], a)
        for column in range(instruments.shape[1]):
            z[bound, column] = filter_all_pole(np.ascontiguousarray(instruments[bound, column]), a)
            phi[bound, column] = filter_all_pole(np.ascontiguousarray(regression.phi[bound, column]), a)
    return z, phi, y


def _stabilise(model: DiscreteModel) -> DiscreteModel:
    """Mirror poles outside the unit circle into it; the auxiliary model only has to follow u."""
    poles = model.poles
    if np.all(np.abs(poles) <= _LARGEST_POLE):
        return model
    mirrored = np.where(np.abs(poles) > 1.0, 1.0 / np.conj(poles), poles)
    size = np.abs(mirrored)
    mirrored = np.where(size > _LARGEST_POLE, mirrored / np.maximum(size, 1e-300) * _LARGEST_POLE, mirrored)
    return DiscreteModel(
        a=np.real(np.poly(mirrored))[1:].copy(),
        b=model.b,
        c=model.c,
        delay=model.delay,
        covariance=model.covariance,
        sample_time_s=model.sample_time_s,
    )


def _give_up(first: BatchEstimate, why: str) -> BatchEstimate:
    note = f"instrumental variables failed ({why}); these are the least-squares parameters"
    return BatchEstimate(
        theta=first.theta,
        covariance=first.covariance,
        noise_variance=first.noise_variance,
        notes=(*first.notes, note),
    )
