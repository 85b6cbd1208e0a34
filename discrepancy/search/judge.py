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
    J, r = fit.jacobian, fit.residual
    p = J.shape[1]
    normal = J.T @ J
    scale = np.sqrt(np.diag(normal)) + 1e-12
    ridge = np.diag(scale**2) * 1e-10
    losses = np.empty(len(blocks))
    for b, parts in enumerate(blocks):
        rb = np.concatenate([r[part] for part in parts])
        if p == 0:
            losses[b] = rb @ rb
            continue
        Jb = np.concatenate([J[part] for part in parts])
        # What this block alone shows must stay where it was: the cut at small singular values sees to that.
        moved = np.linalg.lstsq(normal - Jb.T @ Jb + ridge, Jb.T @ rb, rcond=1e-13)[0]
        left = rb + Jb @ moved
        losses[b] = left @ left
    return HeldOut(loss=float(losses.sum()), blocks=losses)
