"""Instrumental variables: no bias from output noise; and coverage of the confidence intervals."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from estimators.batch_ls import solve_least_squares
from estimators.dataset import Dataset
from estimators.instrumental import fit_instrumental, solve_instrumental
from estimators.model import model_from_theta
from estimators.regressors import build_regression
from estimators.rls import RlsOptions, make_rls
from estimators.settings import IdentifyOptions
from estimators.state import EstimatorState
from estimators.structure import ModelStructure

Array = NDArray[np.float64]
TRUTH = np.array([-1.5, 0.7, 1.0, 0.5])
STRUCTURE = ModelStructure(na=2, nb=2)


def draw_output_error(simulate: Callable[..., Array], seed: int, n: int, share: float) -> Dataset:
    rng = np.random.default_rng(seed)
    u = rng.normal(size=n)
    clean = simulate(u)
    return Dataset(u=u, y=clean + share * clean.std() * rng.normal(size=n), sample_time_s=0.2)


def test_instrumental_variables_have_a_fifth_of_least_squares_bias(simulate: Callable[..., Array]) -> None:
    squares, instruments = [], []
    for seed in range(40):
        record = draw_output_error(simulate, seed, 2000, 0.1)
        squares.append(solve_least_squares(build_regression(record, STRUCTURE)).theta)
        instruments.append(fit_instrumental(record, IdentifyOptions()).theta)
    bias_squares = np.linalg.norm(np.mean(squares, axis=0) - TRUTH)
    bias_instruments = np.linalg.norm(np.mean(instruments, axis=0) - TRUTH)
    assert bias_instruments <= bias_squares / 5


def test_instruments_do_not_reach_across_a_hole(simulate: Callable[..., Array]) -> None:
    record = draw_output_error(simulate, 1, 3000, 0.1)
    broken = Dataset(
        u=np.concatenate([record.u[:1000], record.u[1700:]]),
        y=np.concatenate([record.y[:1000], record.y[1700:]]),
        sample_time_s=0.2,
        starts=(0, 1000),
    )
    estimate = fit_instrumental(broken, IdentifyOptions())
    np.testing.assert_allclose(estimate.theta, TRUTH, atol=6 * np.sqrt(np.diag(estimate.covariance)).max())
    assert estimate.notes == ()


def test_data_that_say_nothing_fall_back_to_least_squares_with_a_note() -> None:
    record = Dataset(u=np.zeros(50), y=np.random.default_rng(0).normal(size=50), sample_time_s=0.2)
    estimate = fit_instrumental(record, IdentifyOptions())
    assert "these are the least-squares parameters" in estimate.notes[-1]
    assert np.isinf(estimate.covariance[2, 2])


def test_an_iteration_that_does_not_settle_ends_with_its_best_model(simulate: Callable[..., Array]) -> None:
    # Two parameters pairs for a plant that needs one: a flat valley in which the iteration wanders.
    rng = np.random.default_rng(3)
    u = np.sin(0.1 * np.arange(400))
    record = Dataset(u=u, y=simulate(u, a=(-0.8,), b=(0.2,)) + 0.01 * rng.normal(size=400), sample_time_s=0.2)
    estimate = solve_instrumental(record, ModelStructure(na=3, nb=3), 2)
    model = model_from_theta(estimate.theta, estimate.covariance, ModelStructure(na=3, nb=3), 0.2)
    assert "did not settle" in estimate.notes[0]
    assert model.simulable


def count_coverage(estimates: Array, errors: Array) -> Array:
    covered: Array = np.mean(np.abs(estimates - TRUTH) <= 1.96 * errors, axis=0)
    return covered


@pytest.mark.slow
def test_intervals_of_instrumental_variables_cover_the_truth(simulate: Callable[..., Array]) -> None:
    found = [
        fit_instrumental(draw_output_error(simulate, s, 500, 0.1), IdentifyOptions()) for s in range(500)
    ]
    estimates = np.array([estimate.theta for estimate in found])
    errors = np.array([np.sqrt(np.diag(estimate.covariance)) for estimate in found])
    assert np.all(np.abs(count_coverage(estimates, errors) - 0.95) <= 0.03)


@pytest.mark.parametrize("lam", [1.0, 0.98])
def test_intervals_of_rls_cover_the_truth(simulate: Callable[..., Array], lam: float) -> None:
    estimator = make_rls(4, RlsOptions(forgetting=lam))
    states: list[EstimatorState] = []
    for seed in range(500):
        rng = np.random.default_rng(seed)
        u, e = rng.normal(size=400), 0.3 * rng.normal(size=400)
        record = Dataset(u=u, y=simulate(u, equation_noise=e), sample_time_s=0.2)
        rows = build_regression(record, STRUCTURE)
        states.append(estimator.init())
        estimator.run(states[-1], rows.phi, rows.y, keep_history=False)
    estimates = np.array([state.theta for state in states])
    errors = np.array([state.standard_errors() for state in states])
    assert np.all(np.abs(count_coverage(estimates, errors) - 0.95) <= 0.03)
