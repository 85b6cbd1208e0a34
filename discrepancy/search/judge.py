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
ALONE = 0.9
"""A direction of the parameters of which a block holds more than this part of the information is shown by it alone."""


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
    """Return the loss of each block predicted by a fit to all the others.

    What one block alone shows (the stiffness of a stop that was touched in it) cannot be predicted from the others, and
    a linearised fit would carry it anywhere: along such directions the fit stays where it was.
    """
    blocks = problem.blocks(BLOCK_S)
    J, r = fit.jacobian, fit.residual
    scale = np.sqrt(np.einsum("ij,ij->j", J, J)) + 1e-12
    size, axes = np.linalg.eigh((J / scale).T @ (J / scale))
    # In these coordinates the whole information is the unit matrix; a block's share of it has values from 0 to 1.
    known = size > 1e-13 * size.max(initial=0.0)
    J = J / scale @ (axes[:, known] / np.sqrt(size[known]))
    losses = np.empty(len(blocks))
    for b, parts in enumerate(blocks):
        rb = np.concatenate([r[part] for part in parts])
        Jb = np.concatenate([J[part] for part in parts])
        share, directions = np.linalg.eigh(Jb.T @ Jb)
        moved = np.where(share < ALONE, 1.0 / (1.0 - np.minimum(share, ALONE)), 0.0)
        left = rb + Jb @ (directions @ (moved * (directions.T @ (Jb.T @ rb))))
        losses[b] = left @ left
    return HeldOut(loss=float(losses.sum()), blocks=losses)
