"""Speed of the estimators beside C and beside other packages: one process, one data set.

Run with `python -m benchmarks.estimators`. Times are the best of several runs, in nanoseconds a sample; quote
the ratios, times swing with the machine. Every peer gets the regressors ready made and is asked for the
same thing, one RLS with four parameters, lambda = 1 and P0 = 1e6; peers that cannot return a history do less.
"""

import ctypes
import importlib
import platform
import subprocess
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from estimators.batch_ls import solve_least_squares
from estimators.dataset import Dataset
from estimators.erls import make_erls
from estimators.identify import identify
from estimators.recursive import RecursiveEstimator
from estimators.regressors import Regression, build_regression
from estimators.rls import RlsOptions, make_rls
from estimators.rls_kf import RlsKfOptions, make_rls_kf
from estimators.settings import IdentifyOptions
from estimators.start import Start
from estimators.structure import ModelStructure

Array = NDArray[np.float64]
# Nanoseconds a sample, parameters, samples.
PeerRun = tuple[float, Array, int]
N = 100_000
P0 = 1e6
STRUCTURE = ModelStructure(na=2, nb=2)


def main() -> None:
    """Print all tables."""
    print(f"{platform.processor() or platform.machine()}, Python {platform.python_version()}, N = {N}")
    rows = make_rows(N)
    reference = solve_least_squares(rows).theta
    ours = compare_with_c(rows, reference)
    compare_with_peers(rows, ours, reference)
    time_papers_computation()


def make_rows(n: int) -> Regression:
    """Return the regression of a second-order plant with white equation noise."""
    rng = np.random.default_rng(0)
    u, e = rng.normal(size=n + 2), 0.1 * rng.normal(size=n + 2)
    y = np.zeros(n + 2)
    for k in range(2, n + 2):
        y[k] = 1.5 * y[k - 1] - 0.7 * y[k - 2] + u[k - 1] + 0.5 * u[k - 2] + e[k]
    return build_regression(Dataset(u=u, y=y, sample_time_s=0.2), STRUCTURE)


def measure(*works: Callable[[], object], repeats: int = 40) -> list[float]:
    """Return each work's shortest run, in seconds; taken in turns, so that a busy machine is fair to all."""
    best = [float("inf")] * len(works)
    for round_ in range(repeats + 1):
        for i, work in enumerate(works):
            begin = time.perf_counter()
            work()
            if round_ > 0:  # the first round warms up
                best[i] = min(best[i], time.perf_counter() - begin)
    return best


def compare_with_c(rows: Regression, reference: Array) -> float:
    """Print our kernels beside the same loop in C; return nanoseconds a sample of RLS."""
    options = RlsOptions(start=Start(p0=P0))
    cases: list[tuple[str, RecursiveEstimator]] = [
        ("RLS, 4 parameters", make_rls(4, options)),
        ("RLS, 4 parameters, lambda = 0.999", make_rls(4, RlsOptions(forgetting=0.999, start=Start(p0=P0)))),
        ("ERLS, 5 parameters", make_erls(4, 1, options)),
        ("RLS-KF, 4 parameters", make_rls_kf(4, RlsKfOptions(start=Start(p0=P0)))),
    ]
    library = compile_c()
    print(f"\n{'predictions and history included':38} {'ours':>8} {'C -O3':>8} {'ratio':>6}  ns a sample")
    found = []
    for name, estimator in cases:
        works = partial(run_ours, estimator, rows), partial(run_c, library, estimator, rows)
        ours, c = (seconds / N * 1e9 for seconds in measure(*works))
        print(f"{name:38} {ours:8.1f} {c:8.1f} {ours / c:6.2f}")
        found.append(ours)
    theta = run_ours(cases[0][1], rows)
    print(f"RLS against batch least squares: {np.max(np.abs(theta - reference)):.1e}")
    print(f"RLS against the C loop:          {np.max(np.abs(theta - run_c(library, cases[0][1], rows))):.1e}")
    record = Dataset(u=rows.y, y=rows.y, sample_time_s=0.2)
    (build,) = measure(partial(build_regression, record, STRUCTURE))
    print(f"building the regressors from u and y: {build / N * 1e9:.1f} ns a sample more")
    return found[0]


def run_ours(estimator: RecursiveEstimator, rows: Regression) -> Array:
    """Run our kernel over the rows, predictions and history included, and return theta."""
    state = estimator.init()
    estimator.run(state, rows.phi, rows.y)
    return state.theta


def compile_c() -> ctypes.CDLL:
    """Compile the C loop with gcc -O3 for this machine."""
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "loop.so"
        source = Path(__file__).with_name("estimators_loop.c")
        command = ["gcc", "-O3", "-march=native", "-shared", "-fPIC", str(source), "-o", str(library)]
        subprocess.run(command, check=True)
        return ctypes.CDLL(str(library))


def run_c(library: ctypes.CDLL, estimator: RecursiveEstimator, rows: Regression) -> Array:
    """Run the C loop over the rows and return theta."""
    weights, n = estimator.weights, estimator.theta0.size
    theta, U, D = estimator.theta0.copy(), np.eye(n), weights.p0.copy()
    outputs = [
        np.empty(rows.y.size),
        np.empty(rows.y.size),
        np.empty(rows.y.size),
        np.empty((rows.y.size, n)),
    ]

    def point(array: Array) -> ctypes.c_void_p:
        return ctypes.c_void_p(array.ctypes.data)

    library.run_recursion(
        ctypes.c_long(rows.y.size), ctypes.c_long(estimator.n_phi), ctypes.c_long(n), point(rows.phi), point(rows.y),
        ctypes.c_double(weights.lam), ctypes.c_double(weights.rv), point(weights.rw), ctypes.c_int(weights.widen),
        point(theta), point(U), point(D), *(point(array) for array in outputs),
    )  # fmt: skip
    return theta


def compare_with_peers(rows: Regression, ours: float, reference: Array) -> None:
    """Print other packages beside our RLS."""
    peers: dict[str, Callable[[Regression], PeerRun]] = {
        "numpy batch lstsq": run_lstsq,
        "padasip FilterRLS.run": run_padasip,
        "filterpy KalmanFilter": run_filterpy,
        "statsmodels RecursiveLS": partial(run_statsmodels, n=N),
        "statsmodels RecursiveLS, short record": partial(run_statsmodels, n=5000),
        "sippy-unipi GEN_RLS_id": run_sippy,
    }
    print(f"\n{'peer':38} {'ns':>8} {'x ours':>8}  largest difference to batch least squares")
    print(f"{'ours, RLS':38} {ours:8.1f} {1.0:8.1f}")
    for name, run in peers.items():
        try:
            nanoseconds, theta, n = run(rows)
        except ModuleNotFoundError as error:
            print(f"{name:38} skipped: {error}")
            continue
        batch = solve_least_squares(cut_rows(rows, n)).theta
        difference = np.max(np.abs(theta - batch))
        print(f"{name:38} {nanoseconds:8.0f} {nanoseconds / ours:8.0f}  {difference:.1e} ({n} samples)")


def cut_rows(rows: Regression, n: int) -> Regression:
    """Return the first n rows."""
    return Regression(
        structure=rows.structure, phi=rows.phi[:n], y=rows.y[:n], rows=rows.rows[:n], bounds=(slice(0, n),)
    )


def run_lstsq(rows: Regression) -> PeerRun:
    """Time numpy's batch least squares."""
    (seconds,) = measure(lambda: np.linalg.lstsq(rows.phi, rows.y, rcond=None))
    return (
        seconds / N * 1e9,
        np.asarray(np.linalg.lstsq(rows.phi, rows.y, rcond=None)[0], dtype=np.float64),
        N,
    )


def run_padasip(rows: Regression) -> PeerRun:
    """Time padasip's RLS."""
    filters = importlib.import_module("padasip.filters")
    n = N
    found = filters.FilterRLS(4, mu=1.0, eps=1 / P0, w="zeros")
    begin = time.perf_counter()
    _, _, history = found.run(rows.y[:n], rows.phi[:n])
    seconds = time.perf_counter() - begin
    return seconds / n * 1e9, np.asarray(history[-1]), n


def run_filterpy(rows: Regression) -> PeerRun:
    """Time filterpy's Kalman filter with the parameters as its state."""
    kalman = importlib.import_module("filterpy.kalman")
    n = N
    found = kalman.KalmanFilter(dim_x=4, dim_z=1)
    found.P, found.Q, found.R = P0 * np.eye(4), np.zeros((4, 4)), np.eye(1)
    begin = time.perf_counter()
    for k in range(n):
        found.update(rows.y[k], H=rows.phi[k : k + 1])
    seconds = time.perf_counter() - begin
    return seconds / n * 1e9, found.x.ravel(), n


def run_statsmodels(rows: Regression, n: int) -> PeerRun:
    """Time statsmodels' RecursiveLS, and print how far our filter is from it after the same diffuse start."""
    recursive = importlib.import_module("statsmodels.regression.recursive_ls")
    fit = recursive.RecursiveLS(rows.y[:n], rows.phi[:n]).fit()
    (seconds,) = measure(lambda: recursive.RecursiveLS(rows.y[:n], rows.phi[:n]).fit(), repeats=3)
    history = np.asarray(fit.recursive_coefficients.filtered).T
    first = 50
    start = solve_least_squares(cut_rows(rows, first))
    state = make_rls(4, RlsOptions()).init()
    # The same start: the exact solution after `first` samples, where statsmodels' diffuse start has also ended.
    information = rows.phi[:first].T @ rows.phi[:first]
    state.U, state.D = factor_ud(np.asarray(np.linalg.inv(information), dtype=np.float64))
    state.theta = start.theta.copy()
    trace = make_rls(4, RlsOptions()).run(state, rows.phi[first:n], rows.y[first:n])
    difference = np.max(np.abs(trace.theta - history[first:]))
    print(f"{'ours to statsmodels, same start':38} {difference:.1e} (largest, whole history)")
    return seconds / n * 1e9, np.asarray(fit.params), n


def factor_ud(P: Array) -> tuple[Array, Array]:
    """Return U and D with P = U diag(D) U', U unit upper triangular."""
    lower = np.linalg.cholesky(P[::-1, ::-1])[::-1, ::-1]
    scale = np.diag(lower)
    return np.ascontiguousarray(lower / scale), scale**2


def run_sippy(rows: Regression) -> PeerRun:
    """Time sippy-unipi's recursive ARX, which builds its regressors itself (P0 = 1e4 is fixed in its code)."""
    module = importlib.import_module("sippy_unipi.io_rls")
    n = N
    # Undo the regressors: row k holds [-y(k-1), -y(k-2), u(k-1), u(k-2)].
    y = np.concatenate([-rows.phi[0, 1::-1], rows.y[:n]])
    u = np.concatenate([rows.phi[0, :1:-1], rows.phi[1:n, 2], [0.0]])
    # Version 1.0.1 puts arrays of one element where numpy 2.4 insists on numbers; it gets arrays that allow it.
    forgiving = SimpleNamespace(**{**vars(np), "zeros": lambda shape: np.zeros(shape).view(ForgivingArray)})
    with patch.object(module, "np", forgiving):
        begin = time.perf_counter()
        b, a, *_ = module.GEN_RLS_id("ARX", y, u, 2, 2, 0, 0, 0, 0, 1)
        seconds = time.perf_counter() - begin
    return seconds / n * 1e9, np.concatenate([a[1:3], b[:2]]), n


class ForgivingArray(np.ndarray[tuple[int, ...], np.dtype[np.float64]]):
    """An array that takes an array of one element where one number is expected, as numpy did before 2.4."""

    def __setitem__(self, key: Any, value: Any) -> None:  # Any: whatever numpy takes
        """Set elements."""
        if isinstance(key, int) and np.size(value) == 1:
            value = np.asarray(value).item()
        super().__setitem__(key, value)


def time_papers_computation() -> None:
    """Print the time of the paper's whole computation: training and test, 5006 samples each."""
    t = 0.2 * np.arange(5006)
    rng = np.random.default_rng(1)
    records = []
    for u in (np.sin(2 * np.pi * t / 50), np.clip(1.5 * (4 * np.abs((t / 40) % 1 - 0.5) - 1), -1, 1)):
        y = np.zeros_like(u)
        for k in range(1, y.size):
            y[k] = 0.798 * y[k - 1] + 0.202 * u[k - 1]
        records.append(Dataset(u=u, y=y + 0.01 * rng.normal(size=y.size), sample_time_s=0.2))
    options = IdentifyOptions(select_order=False)
    best: dict[str, float] = {}
    for _ in range(10):
        result = identify(records[0], records[1], options, clock=time.perf_counter)
        for name, method in result.methods.items():
            seconds = method.computing_time_s or 0.0
            best[name] = min(best.get(name, seconds), seconds)
    print(
        "\nthe paper's computation: training + test, all four figures on both records [ms] (paper: seconds)"
    )
    for name, paper in (("rls", 2.85), ("erls", 3.02), ("rls_kf", 3.15)):
        print(f"{name:8} {1e3 * best[name]:6.2f}   paper {paper} s, {paper / best[name]:,.0f} times longer")


if __name__ == "__main__":
    main()
