"""How much better is one fitted model than another on data it was not fitted to, and is the difference material?

Every block of a training record is held out once. With J the Jacobian at the fitted point, leaving block b out moves
the fit
by the closed form of linear regression, so the held-out residual of the block is (I - H_b)^-1 r_b (the PRESS residual,
D. M. Allen, Technometrics 16, 1974): one fit gives all folds.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discrepancy.fitting.levenberg import Fit
from discrepancy.fitting.problem import SimulationProblem

FloatArray = NDArray[np.float64]

BLOCK_S = 2.0
_RIDGE = 1e-10
"""Added to the information matrix of columns of unit length."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HeldOut:
    """Held-out loss of a fitted model.

    Attributes:
        loss: sum over all blocks of the squared held-out residual, in units of the noise variance.
        blocks: the same by block, shape (B,).
    """

    loss: float
    blocks: FloatArray


def held_out(problem: SimulationProblem, fit: Fit) -> HeldOut:
    """Return the loss of each block predicted by a fit to all the others."""
    blocks = problem.blocks(BLOCK_S)
    scale = np.linalg.norm(fit.jacobian, axis=0) + 1e-12
    J, r = fit.jacobian / scale, fit.residual
    if J.shape[1] == 0:
        losses = np.array([sum(float(r[part] @ r[part]) for part in parts) for parts in blocks])
        return HeldOut(loss=float(losses.sum()), blocks=losses)
    inside = np.stack([sum(J[part].T @ J[part] for part in parts) for parts in blocks])
    right = np.stack([sum(J[part].T @ r[part] for part in parts) for parts in blocks])
    # What one block alone shows is lost without it: the ridge keeps that direction where it was.
    normal = J.T @ J + _RIDGE * np.eye(J.shape[1])
    moved = np.linalg.solve(normal - inside, right[:, :, None])[:, :, 0]
    losses = np.empty(len(blocks))
    for b, parts in enumerate(blocks):
        left = np.concatenate([r[part] + J[part] @ moved[b] for part in parts])
        losses[b] = left @ left
    return HeldOut(loss=float(losses.sum()), blocks=losses)
