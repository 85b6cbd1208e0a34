"""Coverage of the confidence intervals and bias under output noise, by Monte Carlo.

Run with `python -m benchmarks.estimators_statistics`. Plant: z^2 - 1.5 z + 0.7 under white input.
"""

import numpy as np
from numpy.typing import NDArray

from estimators.batch_ls import BatchEstimate, fit_least_squares
from estimators.dataset import Dataset
from estimators.instrumental import fit_instrumental
from estimators.regressors import build_regression
from estimators.rls import RlsOptions, make_rls
from estimators.rls_kf import make_rls_kf
from estimators.rls_kf_ml import estimate_noise
from estimators.settings import IdentifyOptions

Array = NDArray[np.float64]
TRUTH = np.array([-1.5, 0.7, 1.0, 0.5])
RUNS, SAMPLES = 1000, 500
OPTIONS = IdentifyOptions()


def main() -> None:
    """Print coverage per parameter, then bias."""
    print(f"coverage of 95 % intervals, {RUNS} runs of {SAMPLES} samples (a1, a2, b0, b1)")
    equation = [draw_record(seed, SAMPLES, equation_noise=True) for seed in range(RUNS)]
    output = [draw_record(seed, SAMPLES, equation_noise=False) for seed in range(RUNS)]
    print_coverage("batch LS, equation noise", [summarise(fit_least_squares(r, OPTIONS)) for r in equation])
    print_coverage("RLS, equation noise", [run_rls(r, 1.0) for r in equation])
    print_coverage("RLS lambda 0.98, equation noise", [run_rls(r, 0.98) for r in equation])
    print_coverage("RLS-KF (ML), equation noise", [run_kf_ml(r) for r in equation])
    print_coverage("IV, 10 % output noise", [summarise(fit_instrumental(r, OPTIONS)) for r in output])

    print("\nbias of (a1, a2, b0, b1) at 10 % output noise, 200 runs of 5000 samples")
    long = [draw_record(seed, 5000, equation_noise=False) for seed in range(200)]
    squares = np.mean([fit_least_squares(r, OPTIONS).theta for r in long], axis=0) - TRUTH
    instruments = np.mean([fit_instrumental(r, OPTIONS).theta for r in long], axis=0) - TRUTH
    print(f"LS {squares.round(5)}\nIV {instruments.round(5)}")
    print(f"norm of IV's bias / norm of LS's: {np.linalg.norm(instruments) / np.linalg.norm(squares):.4f}")


def draw_record(seed: int, n: int, *, equation_noise: bool) -> Dataset:
    """Return a record with white noise in the equation (standard deviation 0.3) or on the output (10 %)."""
    rng = np.random.default_rng(seed)
    u, e = rng.normal(size=n), rng.normal(size=n)
    y = np.zeros(n)
    for k in range(2, n):
        y[k] = 1.5 * y[k - 1] - 0.7 * y[k - 2] + u[k - 1] + 0.5 * u[k - 2] + 0.3 * e[k] * equation_noise
    if not equation_noise:
        y += 0.1 * y.std() * e
    return Dataset(u=u, y=y, sample_time_s=0.2)


def summarise(estimate: BatchEstimate) -> tuple[Array, Array]:
    """Return theta and its standard errors."""
    return estimate.theta, np.sqrt(np.diag(estimate.covariance))


def run_rls(record: Dataset, lam: float) -> tuple[Array, Array]:
    """Return theta and its standard errors from RLS."""
    rows = build_regression(record, OPTIONS.structure)
    estimator = make_rls(4, RlsOptions(forgetting=lam))
    state = estimator.init()
    estimator.run(state, rows.phi, rows.y, keep_history=False)
    return state.theta, state.standard_errors()


def run_kf_ml(record: Dataset) -> tuple[Array, Array]:
    """Return theta and its standard errors from RLS-KF with estimated variances."""
    rows = build_regression(record, OPTIONS.structure)
    estimator = make_rls_kf(4, estimate_noise(rows).options)
    state = estimator.init()
    estimator.run(state, rows.phi, rows.y, keep_history=False)
    return state.theta, state.standard_errors()


def print_coverage(name: str, found: list[tuple[Array, Array]]) -> None:
    """Print the share of runs whose interval holds the truth."""
    estimates, errors = (np.array(column) for column in zip(*found, strict=True))
    covered = np.mean(np.abs(estimates - TRUTH) <= 1.96 * errors, axis=0)
    print(f"{name:34}" + "".join(f"{share:8.1%}" for share in covered))


if __name__ == "__main__":
    main()
