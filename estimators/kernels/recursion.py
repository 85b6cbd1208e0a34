"""One compiled recursion under all recursive estimators: a Kalman filter for parameters in UD form.

Theory of operation. RLS with exponential forgetting, RLS with directional forgetting, extended RLS and the
RLS-KF are one algorithm with different weights. Each sample does

    e     = y - x' theta                        a-priori error (innovation)
    s     = R + x' P x                          its variance in units of the weights
    theta = theta + P x e / s
    P     = (P - w P x x' P / (1 + w x' P x)) / lambda

with R = lambda and w = 1 / lambda for RLS (de Souza et al. 2021, eq. 2-4), R = Rv and w = 1 / Rv for the
RLS-KF (eq. 13-15) after P has been widened by Rw, and R = 1 with a signed w for directional forgetting.
P is never formed. It is kept as P = U diag(D) U' with U unit upper triangular, updated by Bierman's
algorithm (the correction) and by rank-one Agee-Turner updates (the widening); see G. J. Bierman,
Factorization Methods for Discrete Sequential Estimation, 1977, chapters III and V, and app. III.C.
D cannot become negative, so P stays a covariance however long the input is silent.

There are two copies of theta, U and D. A step reads one and writes the other; when every new number is
finite they change roles, and a rejected sample needs no undoing.

`error_model="numpy"` stands for two things: a division cannot raise, and the inner loops lose a branch.
`fastmath={"contract"}` allows fused multiply-add and nothing that could change how a NaN is treated.
`advance` learns its sizes from the lengths of tuples, which belong to their type: it is compiled once for
each pair of sizes, with every loop over parameters unrolled, and a sample costs half of what it does with
sizes known at run time only. It takes its arrays one by one and its parts are inlined: with tuples of arrays,
or with calls, a sample costs a third more. Counters kept in local variables make it slower, not faster.
The parts stay in this file because numba's cache does not notice a change elsewhere.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

# Places in the counters.
ACCEPTED, REJECTED, WEIGHT, WEIGHT_SQUARED, LOSS = range(5)
N_COUNTERS = 5


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def widen_covariance(U: Matrix, D: Vector, rw: Vector, a: Vector) -> None:
    """Replace U, D by the factors of U diag(D) U' + diag(rw), one rank-one update per parameter."""
    D[0] += rw[0]
    for m in range(1, D.shape[0]):
        if rw[m] <= 0.0:
            continue
        d = D[m] + rw[m]
        keep = D[m] / d
        D[m] = d
        for i in range(m):
            a[i] = -U[i, m]
            U[i, m] *= keep
        c = rw[m] * keep
        for j in range(m - 1, 0, -1):
            ca = c * a[j]
            d = D[j] + ca * a[j]
            if d <= 0.0:  # both the direction and its variance are zero: nothing to spread
                continue
            inverse = 1.0 / d
            c *= D[j] * inverse
            D[j] = d
            for i in range(j):
                a[i] -= a[j] * U[i, j]
                U[i, j] += ca * inverse * a[i]
        D[0] += c * a[0] * a[0]


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def correct_covariance(
    U: Matrix,
    D: Vector,
    f: Vector,
    v: Vector,
    w: float,
    grow: float,
    pull: Vector,
    b: Vector,
    U_new: Matrix,
    D_new: Vector,
) -> None:
    """Set U_new, D_new to the factors of grow (P - w P x x' P / (1 + w x' P x)) and b to P x.

    Args:
        U: factor of P, shape (n, n).
        D: factor of P, shape (n,).
        f: U' x, shape (n,).
        v: D f, shape (n,).
        w: weight of the sample; negative for the growing case of directional forgetting.
        grow: 1 / lambda, or 1 for no forgetting.
        pull: scratch, shape (n,).
        b: receives P x with the old P, shape (n,).
        U_new: receives the new factor; may be U itself.
        D_new: receives the new factor; may be D itself.
    """
    n = b.shape[0]
    inverse = 1.0
    alpha = 1.0
    for j in range(n):
        push = w * f[j]
        pull[j] = push * inverse
        previous = alpha
        alpha += push * v[j]
        inverse = 1.0 / alpha
        D_new[j] = D[j] * (previous * inverse) * grow
    for i in range(n):
        total = v[i]
        for j in range(i + 1, n):
            u = U[i, j]
            U_new[i, j] = u - pull[j] * total
            total += u * v[j]
        b[i] = total


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def covariance_trace(U: Matrix, D: Vector) -> float:
    """Return the trace of U diag(D) U'."""
    total = 0.0
    for j in range(D.shape[0]):
        column = 1.0
        for i in range(j):
            column += U[i, j] * U[i, j]
        total += D[j] * column
    return total


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def choose_weight(lam: float, directional: bool, excitation: float, at_limit: bool) -> float:
    """Return w of the correction in units of 1 / Rv; `excitation` is x' P x.

    Directional forgetting: the information matrix gains (lambda - (1 - lambda) / x'Px) x x', which is
    negative where x brings less than forgetting takes away (Bittanti, Bolzern and Campi 1990).
    """
    if not directional:
        return 1.0 / lam
    if excitation <= 0.0:
        return 1.0
    w = lam - (1.0 - lam) / excitation
    return max(w, 0.0) if at_limit else w


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def copy_factors(
    theta_from: Vector, U_from: Matrix, D_from: Vector, theta: Vector, U: Matrix, D: Vector
) -> None:
    """Copy the parameters and the strict upper triangle of U and D."""
    for j in range(D.shape[0]):
        theta[j] = theta_from[j]
        D[j] = D_from[j]
        for i in range(j):
            U[i, j] = U_from[i, j]


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def reset_covariance(p0: Vector, U: Matrix, D: Vector) -> None:
    """Set U to the unit matrix and D to the start values."""
    for j in range(D.shape[0]):
        D[j] = p0[j]
        for i in range(j):
            U[i, j] = 0.0


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def gather_regressor(phi: Matrix, k: int, memory: Vector, lagged: bool, n_phi: int, x: Vector) -> None:
    """Fill x with the regressor of sample k: phi and the past residuals, or the stored regressor."""
    for i in range(n_phi):
        x[i] = memory[i] if lagged else phi[k, i]
    for i in range(n_phi, x.shape[0]):
        x[i] = memory[i - n_phi]


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def project_regressor(
    U: Matrix, D: Vector, theta: Vector, x: Vector, f: Vector, v: Vector
) -> tuple[float, float]:
    """Set f = U' x and v = D f; return the prediction x' theta and x' P x."""
    prior, excitation = 0.0, 0.0
    for j in range(x.shape[0]):
        total = x[j]
        for i in range(j):
            total += U[i, j] * x[i]
        f[j] = total
        v[j] = D[j] * total
        excitation += total * v[j]
        prior += x[j] * theta[j]
    return prior, excitation


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def remember_sample(
    phi: Matrix, k: int, memory: Vector, lagged: bool, n_phi: int, n_residuals: int, residual: float
) -> None:
    """Store what the next sample needs: this regressor, or this residual before the older ones."""
    if lagged:
        for i in range(n_phi):
            memory[i] = phi[k, i]
    for i in range(n_residuals - 1, 0, -1):
        memory[i] = memory[i - 1]
    if n_residuals > 0:
        memory[0] = residual


@njit(cache=True, error_model="numpy", fastmath={"contract"})
def advance(
    sizes: tuple[tuple[int, ...], tuple[int, ...]],
    lam: float,
    rv: float,
    rw: Vector,
    widen: bool,
    directional: bool,
    lagged: bool,
    p0: Vector,
    trace_limit: float,
    reset_interval: int,
    theta: Vector,
    U: Matrix,
    D: Vector,
    memory: Vector,
    counters: Vector,
    phi: Matrix,
    y: Vector,
    priors: Vector,
    posteriors: Vector,
    variances: Vector,
    rejected: NDArray[np.bool_],
    history: Matrix,
) -> int:
    """Advance the state through all samples in place and return how many were rejected.

    The arguments are two tuples, as long as the regressor is without residual terms and as there are residual
    terms (only their lengths matter), the fields of
    `estimators.weights.Weights`, those of `estimators.state.EstimatorState`, the regressors without residual
    terms (N, n_phi) and outputs (N,), and the fields of `estimators.recursive.RunTrace`, which are written;
    `history` may have no rows. A rejected sample leaves the state as it was, but for the count of rejections.
    """
    n_phi, n_residuals = len(sizes[0]), len(sizes[1])
    n = n_phi + n_residuals
    x, f, v, b, pull = np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    thetas, Us, Ds = np.empty((2, n)), np.empty((2, n, n)), np.empty((2, n))
    copy_factors(theta, U, D, thetas[0], Us[0], Ds[0])
    old, new = 0, 1
    forgets = lam < 1.0
    noise = rv if directional else lam * rv
    keep_history = history.shape[0] > 0
    rejections = 0
    for k in range(y.shape[0]):
        gather_regressor(phi, k, memory, lagged, n_phi, x)
        source = old
        if reset_interval > 0 and counters[ACCEPTED] > 0 and counters[ACCEPTED] % reset_interval == 0:
            source = new
            reset_covariance(p0, Us[new], Ds[new])
        if widen:
            if source == old:
                source = new
                copy_factors(thetas[old], Us[old], Ds[old], thetas[new], Us[new], Ds[new])
            widen_covariance(Us[new], Ds[new], rw, b)
        prior, excitation = project_regressor(Us[source], Ds[source], thetas[old], x, f, v)
        at_limit = forgets and covariance_trace(Us[source], Ds[source]) > trace_limit
        weight = choose_weight(lam, directional, excitation / rv, at_limit) / rv
        grow = 1.0 / lam if forgets and not at_limit and not directional else 1.0
        correct_covariance(Us[source], Ds[source], f, v, weight, grow, pull, b, Us[new], Ds[new])
        s = noise + excitation
        step = (y[k] - prior) / s
        # `check` sums every new number: it is finite only if all of them are.
        posterior, check = 0.0, 0.0
        for j in range(n):
            moved = thetas[old, j] + b[j] * step
            thetas[new, j] = moved
            check += moved + Ds[new, j]
            for i in range(j):
                check += Us[new, i, j]
            posterior += x[j] * moved
            if keep_history:
                history[k, j] = moved
        if lagged:
            for i in range(n_phi):
                check += phi[k, i]
        loss = lam * counters[LOSS] + (y[k] - prior) * (y[k] - posterior) / rv
        accepted = np.isfinite(check + loss)
        if accepted:
            old, new = new, old
            remember_sample(phi, k, memory, lagged, n_phi, n_residuals, y[k] - posterior)
            counters[ACCEPTED] += 1.0
            counters[WEIGHT] = lam * counters[WEIGHT] + 1.0
            counters[WEIGHT_SQUARED] = lam * lam * counters[WEIGHT_SQUARED] + 1.0
            counters[LOSS] = loss
        else:
            counters[REJECTED] += 1.0
            rejections += 1
            for j in range(n if keep_history else 0):
                history[k, j] = thetas[old, j]
            posterior = np.nan
        rejected[k] = not accepted
        priors[k] = prior
        posteriors[k] = posterior
        variances[k] = s
    copy_factors(thetas[old], Us[old], Ds[old], theta, U, D)
    return rejections
