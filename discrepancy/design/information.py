"""What a predicted record would tell, for every length at once: information grows sample by sample.

With J the sensitivities of a model's prediction and N0 the information that the records so far hold (both with the
starting states projected out), a record of length t leaves the covariance (N0 + J_t' J_t)^-1. A rival that is fitted to
the old records and to what the truth predicts keeps, to first order,

    r_t' r_t - g_t' (N0 + J_t' J_t)^-1 g_t,   g_t = J_t' r_t,

of the difference r between the two predictions: T-optimality (A. C. Atkinson, V. V. Fedorov, Biometrika 62(1), 1975)
with what is known already. One simulation a parameter gives both for all lengths.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discrepancy.fitting.levenberg import Fit

FloatArray = NDArray[np.float64]

_CONDITION = 1e-12


@dataclass(frozen=True, slots=True, kw_only=True)
class Growth:
    """Sums over the samples of a predicted record, for K lengths.

    Attributes:
        normal: information about the p parameters in scaled coordinates, shape (K, p, p).
        gradient: sensitivities times what the model does not follow, shape (K, p).
        loss: what it does not follow, in noise variances, shape (K,).
    """

    normal: FloatArray
    gradient: FloatArray
    loss: FloatArray


def growth_of(done: Fit, channels: int, rows: FloatArray) -> Growth:
    """Return the sums up to each length; beyond the record they go on growing as they did over it.

    Args:
        done: the model beside the predicted record, not moved.
        channels: outputs, one after the other in the flattened residual.
        rows: lengths in samples, shape (K,).
    """
    n = done.residual.size // channels
    p = done.jacobian.shape[1]
    jacobian = done.jacobian.reshape(channels, n, p)
    residual = done.residual.reshape(channels, n)
    ends = np.minimum(np.round(rows).astype(int), n)
    beyond = np.maximum(1.0, rows / n)
    normal, gradient, loss = np.zeros((p, p)), np.zeros(p), 0.0
    sums = []
    at = 0
    for end in ends:
        J, r = jacobian[:, at:end].reshape(-1, p), residual[:, at:end].ravel()
        normal, gradient, loss = normal + J.T @ J, gradient + J.T @ r, loss + float(r @ r)
        sums.append((normal, gradient, loss))
        at = end
    return Growth(
        normal=np.stack([one[0] for one in sums]) * beyond[:, None, None],
        gradient=np.stack([one[1] for one in sums]) * beyond[:, None],
        loss=np.array([one[2] for one in sums]) * beyond,
    )


def left_apart(prior: FloatArray, grown: Growth) -> FloatArray:
    """Return how far a refitted rival stays from the prediction, in noise variances, shape (K,).

    Args:
        prior: information that the records so far hold about the rival's parameters, shape (p, p).
        grown: of the rival beside the truth's prediction.
    """
    if not prior.size:
        return grown.loss
    whole = prior + grown.normal
    scale = np.sqrt(np.einsum("kii->ki", whole)) + 1e-12
    inverse = np.linalg.pinv(
        whole / (scale[:, :, None] * scale[:, None, :]), rcond=_CONDITION, hermitian=True
    )
    gradient = grown.gradient / scale
    followed = np.einsum("ki,kij,kj->k", gradient, inverse, gradient)
    return np.asarray(np.maximum(0.0, grown.loss - followed))


def errors_left(prior: FloatArray, grown: Growth) -> FloatArray:
    """Return what is left of each parameter's standard error as a part of the present one, shape (K, p)."""
    kept = _variances(prior + grown.normal) / _variances(prior[None])
    return np.asarray(np.sqrt(np.clip(kept, 0.0, 1.0)))


def known_before(done: Fit) -> FloatArray:
    """Return what the records so far tell of a model's parameters, shape (p, p), scaled coordinates.

    Of how a recording was made the range is known too: without it, a record that cannot tell a delay from the timing of
    its input would seem to.
    """
    unit = done.loss / max(1, done.residual.size - len(done.parameters))
    ranges = [q.known_before(float(done.vector[q.slot])) * unit for q in done.parameters]
    return np.asarray(done.normal() + np.diag(ranges))


def _variances(normal: FloatArray) -> FloatArray:
    """Return the diagonals of the inverses, shape (K, p), of information matrices, shape (K, p, p).

    Each is scaled by its own diagonal: a record may tell 1e18 times more about a parameter than the records before it.
    """
    scale = np.sqrt(np.einsum("kii->ki", normal)) + 1e-9
    ridge = _CONDITION * np.eye(normal.shape[-1])
    inverse = np.linalg.inv(normal / (scale[:, :, None] * scale[:, None, :]) + ridge)
    return np.asarray(np.einsum("kii->ki", inverse) / scale**2)
