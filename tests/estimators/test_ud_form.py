"""The UD form: it stays a covariance where the printed equations do not."""

import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimators.kernels.recursion import correct_covariance, covariance_trace, widen_covariance
from estimators.recursive import RecursiveEstimator
from estimators.rls import WINDUP_FACTOR, RlsOptions, make_rls
from estimators.rls_directional import RlsDirectionalOptions, make_rls_directional
from estimators.rls_kf import RlsKfOptions, make_rls_kf
from estimators.start import Start

# Without compilation a sample costs a thousand times more; the statement is then tested on fewer of them.
SILENT_SAMPLES = 20_000 if os.environ.get("NUMBA_DISABLE_JIT", "0") == "1" else 3_000_000


@pytest.mark.slow
@pytest.mark.parametrize(
    "estimator",
    [
        make_rls(4, RlsOptions(forgetting=0.98)),
        make_rls_directional(4, RlsDirectionalOptions(forgetting=0.98)),
        make_rls_kf(4, RlsKfOptions()),
    ],
    ids=["rls", "rls_directional", "rls_kf"],
)
@pytest.mark.parametrize("silence", [0.0, 1e-9, 1.0], ids=["zero", "tiny", "constant"])
def test_millions_of_samples_without_excitation_do_no_harm(
    estimator: RecursiveEstimator, silence: float
) -> None:
    state = estimator.init()
    rng = np.random.default_rng(0)
    phi = rng.normal(size=(200, 4))
    truth = np.array([1.0, -2.0, 0.5, 3.0])
    estimator.run(state, phi, phi @ truth)
    quiet = np.full((SILENT_SAMPLES, 4), silence)
    estimator.run(state, quiet, quiet @ truth, keep_history=False)
    P = state.covariance_factor()
    assert np.all(np.isfinite(P)) and np.all(state.D >= 0)
    estimator.run(state, phi, phi @ truth)
    assert state.rejected == 0
    np.testing.assert_allclose(state.theta, truth, atol=1e-6)


def test_printed_update_loses_definiteness_where_the_ud_form_keeps_it() -> None:
    rng = np.random.default_rng(4)
    n, lam, p0 = 400, 0.95, 1e6
    # Two nearly equal regressors, as y(k-1) and y(k-2) of a slow joint are.
    slow = 10 * np.cumsum(rng.normal(size=n))
    phi = np.column_stack([slow, slow + 1e-7 * rng.normal(size=n)])
    P, worst = p0 * np.eye(2), 0.0
    for row in phi:
        P = (P - np.outer(P @ row, row @ P) / (lam + row @ P @ row)) / lam
        worst = min(worst, float(np.linalg.eigvalsh((P + P.T) / 2)[0] / np.max(np.abs(P))))
    estimator = make_rls(2, RlsOptions(forgetting=lam, start=Start(p0=p0)))
    state = estimator.init()
    estimator.run(state, phi, slow)
    assert worst < -0.5
    assert np.all(state.D > 0)


def test_forgetting_pauses_at_the_windup_limit() -> None:
    estimator = make_rls(2, RlsOptions(forgetting=0.9, start=Start(p0=1.0)))
    state = estimator.init()
    silence = np.zeros((1000, 2))
    estimator.run(state, silence, np.zeros(1000))
    trace = np.trace(state.covariance_factor())
    # The last step taken below the limit may cross it by one factor of 1 / lambda.
    assert WINDUP_FACTOR * 2.0 < trace <= WINDUP_FACTOR * 2.0 / 0.9


factors = st.lists(st.floats(-10, 10), min_size=10, max_size=10)


@settings(max_examples=100, deadline=None)
@given(upper=factors, diagonal=st.lists(st.floats(1e-3, 1e3), min_size=4, max_size=4), extra=factors)
def test_updates_agree_with_the_full_matrix(
    upper: list[float], diagonal: list[float], extra: list[float]
) -> None:
    U, D = np.eye(4), np.array(diagonal)
    U[np.triu_indices(4, 1)] = upper[:6]
    P = (U * D) @ U.T
    x, rw = np.array(extra[:4]), np.abs(np.array(extra[4:8]))
    scale = np.abs(P).max() + 10.0
    widen_covariance(U, D, rw, np.empty(4))
    P = P + np.diag(rw)
    np.testing.assert_allclose((U * D) @ U.T, P, atol=1e-11 * scale)
    assert covariance_trace(U, D) == pytest.approx(np.trace(P), rel=1e-10)
    f = U.T @ x
    gain = np.empty(4)
    correct_covariance(U, D, f, D * f, 0.5, 1.0, np.empty(4), gain, U, D)
    np.testing.assert_allclose(gain, P @ x, atol=1e-9 * scale)
    expected = P - 0.5 * np.outer(P @ x, x @ P) / (1 + 0.5 * x @ P @ x)
    # The right-hand side cancels; its own rounding is about eps * cond.
    np.testing.assert_allclose((U * D) @ U.T, expected, atol=1e-9 * scale)
    assert np.all(D >= 0)
