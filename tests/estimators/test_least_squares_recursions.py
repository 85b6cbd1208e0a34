"""RLS and ERLS against closed forms and against the paper's equations written out with a full P."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from estimators.batch_ls import solve_least_squares
from estimators.dataset import Dataset
from estimators.erls import make_erls
from estimators.regressors import Regression, build_regression
from estimators.rls import RlsOptions, make_rls
from estimators.rls_directional import RlsDirectionalOptions, make_rls_directional
from estimators.start import Start
from estimators.structure import ModelStructure

Array = NDArray[np.float64]


def follow_printed_rls(phi: Array, y: Array, lam: float, p0: float) -> tuple[Array, Array]:
    """Eq. 2 to 4 of the paper, line by line."""
    n = phi.shape[1]
    theta, P = np.zeros(n), p0 * np.eye(n)
    for row, value in zip(phi, y, strict=True):
        denominator = lam + row @ P @ row
        L = P @ row / denominator
        theta = theta + L * (value - row @ theta)
        P = (P - np.outer(P @ row, row @ P) / denominator) / lam
    return theta, P


@pytest.mark.parametrize("lam", [1.0, 0.97])
def test_rls_follows_the_printed_equations(regression: Regression, lam: float) -> None:
    estimator = make_rls(4, RlsOptions(forgetting=lam, start=Start(p0=100.0)))
    state = estimator.init()
    estimator.run(state, regression.phi, regression.y)
    theta, P = follow_printed_rls(regression.phi, regression.y, lam, 100.0)
    # The printed form loses about cond(P) * eps = 1e-11 against the UD form.
    np.testing.assert_allclose(state.theta, theta, rtol=1e-9)
    np.testing.assert_allclose(state.covariance_factor(), P, rtol=1e-7, atol=1e-12)


@pytest.mark.parametrize("lam", [1.0, 0.99])
def test_rls_minimises_the_weighted_sum_of_squares(regression: Regression, lam: float) -> None:
    p0, theta0 = 50.0, 0.3
    estimator = make_rls(4, RlsOptions(forgetting=lam, start=Start(p0=p0, theta0=theta0)))
    state = estimator.init()
    estimator.run(state, regression.phi, regression.y)
    weights = lam ** np.arange(regression.y.size - 1, -1, -1)
    pull = lam**regression.y.size / p0 * np.eye(4)
    information = regression.phi.T @ (weights[:, None] * regression.phi) + pull
    expected = np.linalg.solve(
        information, regression.phi.T @ (weights * regression.y) + pull @ np.full(4, theta0)
    )
    np.testing.assert_allclose(state.theta, expected, rtol=1e-10)


def test_rls_with_a_large_start_equals_batch_least_squares_to_1e_7(regression: Regression) -> None:
    estimator = make_rls(4, RlsOptions(start=Start(p0=1e6)))
    state = estimator.init()
    estimator.run(state, regression.phi, regression.y)
    batch = solve_least_squares(regression)
    np.testing.assert_allclose(state.theta, batch.theta, atol=1e-7)
    np.testing.assert_allclose(state.covariance(), batch.covariance, rtol=1e-4)


def test_one_parameter_rls_is_the_running_mean() -> None:
    estimator = make_rls(1, RlsOptions(start=Start(p0=0.5)))
    state = estimator.init()
    y = np.array([3.0, 5.0, 10.0])
    trace = estimator.run(state, np.ones((3, 1)), y)
    # A start with P0 = 1/2 weighs as much as two samples of zero.
    np.testing.assert_allclose(trace.theta[:, 0], [3 / 3, 8 / 4, 18 / 5], rtol=1e-15)
    np.testing.assert_allclose(trace.prior, [0.0, 3 / 3, 8 / 4], rtol=1e-15)
    np.testing.assert_allclose(trace.posterior, trace.theta[:, 0], rtol=1e-15)


def test_covariance_reset_restarts_from_the_parameters_reached(regression: Regression) -> None:
    phi, y = regression.phi[:150], regression.y[:150]
    estimator = make_rls(4, RlsOptions(reset_interval=100, start=Start(p0=10.0)))
    state = estimator.init()
    estimator.run(state, phi, y)
    first = make_rls(4, RlsOptions(start=Start(p0=10.0)))
    before = first.init()
    first.run(before, phi[:100], y[:100])
    second = make_rls(4, RlsOptions(start=Start(p0=10.0, theta0=tuple(before.theta))))
    after = second.init()
    second.run(after, phi[100:], y[100:])
    np.testing.assert_allclose(state.theta, after.theta, rtol=1e-12)


@pytest.mark.parametrize("nc", [1, 2])
def test_erls_follows_the_printed_equations(regression: Regression, nc: int) -> None:
    estimator = make_erls(4, nc, RlsOptions(start=Start(p0=100.0)))
    state = estimator.init()
    trace = estimator.run(state, regression.phi, regression.y)
    theta, P, residuals = np.zeros(4 + nc), 100.0 * np.eye(4 + nc), [0.0] * nc
    for k, (row, value) in enumerate(zip(regression.phi, regression.y, strict=True)):
        phi = np.concatenate([row, residuals])
        L = P @ phi / (1.0 + phi @ P @ phi)
        theta = theta + L * (value - phi @ theta)
        P = P - np.outer(L, phi @ P)
        residuals = [float(value - phi @ theta), *residuals[: nc - 1]]
        assert trace.posterior[k] == pytest.approx(value - residuals[0], abs=1e-9)
    np.testing.assert_allclose(state.theta, theta, rtol=1e-8)


def test_erls_removes_the_bias_of_moving_average_noise(simulate: Callable[..., Array]) -> None:
    rng = np.random.default_rng(3)
    u, e = rng.normal(size=20_000), 0.5 * rng.normal(size=20_000)
    noise = e + 0.8 * np.concatenate([[0.0], e[:-1]])
    record = Dataset(u=u, y=simulate(u, equation_noise=noise), sample_time_s=0.2)
    rows = build_regression(record, ModelStructure(na=2, nb=2))
    estimator = make_erls(4, 1, RlsOptions())
    state = estimator.init()
    estimator.run(state, rows.phi, rows.y)
    # Five standard errors of a fit to 20 000 samples are about 0.02; least squares is off by 0.06.
    np.testing.assert_allclose(state.theta, [-1.5, 0.7, 1.0, 0.5, 0.8], atol=0.025)
    assert abs(solve_least_squares(rows).theta[1] - 0.7) > 0.04


def test_erls_without_residual_terms_is_refused() -> None:
    with pytest.raises(ValueError, match="n_residuals=0 must be at least 1"):
        make_erls(4, 0, RlsOptions())


@pytest.mark.parametrize(
    ("forgetting", "text"),
    [(1.2, r"forgetting=1.2 must lie in \(0, 1\]; use 1.0 for none"), (0.0, "forgetting=0.0")],
)
def test_forgetting_out_of_range_is_refused(forgetting: float, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        RlsOptions(forgetting=forgetting)


def test_directional_forgetting_follows_its_equations(regression: Regression) -> None:
    lam = 0.95
    estimator = make_rls_directional(4, RlsDirectionalOptions(forgetting=lam, start=Start(p0=100.0)))
    state = estimator.init()
    estimator.run(state, regression.phi, regression.y)
    theta, P = np.zeros(4), 100.0 * np.eye(4)
    for row, value in zip(regression.phi, regression.y, strict=True):
        r = row @ P @ row
        theta = theta + P @ row * (value - row @ theta) / (1 + r)
        beta = lam - (1 - lam) / r
        P = P - np.outer(P @ row, P @ row) / (1 / beta + r)
    np.testing.assert_allclose(state.theta, theta, rtol=1e-8)
    np.testing.assert_allclose(state.covariance_factor(), P, rtol=1e-7)


def test_directional_forgetting_keeps_what_is_not_excited() -> None:
    estimator = make_rls_directional(2, RlsDirectionalOptions(forgetting=0.9, start=Start(p0=10.0)))
    state = estimator.init()
    both = np.random.default_rng(0).normal(size=(50, 2))
    estimator.run(state, both, both @ np.array([1.0, 2.0]))
    known = state.covariance_factor()[1, 1]
    only_first = np.zeros((2000, 2))
    only_first[:, 0] = 1.0
    estimator.run(state, only_first, only_first @ np.array([-1.0, 2.0]))
    assert state.theta[0] == pytest.approx(-1.0, abs=1e-9)
    # Forgetting in all directions would have multiplied this variance by 0.9^-2000.
    assert state.covariance_factor()[1, 1] <= 2.0 * known
