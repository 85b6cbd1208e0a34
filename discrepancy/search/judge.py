"""How much better is one fitted model than another on data it was not fitted to, and is the difference material?

Every block of a training record is held out once. With J the Jacobian at the fitted point, leaving block b out moves
the fit
by the closed form of linear regression, so the held-out residual of the block is (I - H_b)^-1 r_b (the PRESS residual,
D. M. Allen, Technometrics 16, 1974): one fit gives all folds.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discrepancy.fitting.levenberg import COARSE_DIFFERENCE, Fit
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.simulation import slots as s

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


def farthest_move(fit: Fit) -> float:
    """Return how far a fit without one block may move in scaled coordinates: with play, no farther than its hollow.

    There a linearised step says nothing beyond the distance over which slopes were taken.
    """
    return COARSE_DIFFERENCE if fit.vector[s.GAP] > 0.0 else np.inf


def held_out(problem: SimulationProblem, fit: Fit, farthest: float = np.inf) -> HeldOut:
    """Return the loss of each block predicted by a fit to all the others.

    What one block alone shows (the stiffness of a stop that was touched in it) cannot be predicted from the others, and
    a linearised fit would carry it anywhere: along such directions the fit stays where it was.

    Args:
        problem: data and noise of the fit.
        fit: the fitted point.
        farthest: most that leaving out a block may move any coordinate of the Jacobian.
    """
    blocks = problem.blocks(BLOCK_S)
    J, r = fit.jacobian, fit.residual
    scale = np.sqrt(np.einsum("ij,ij->j", J, J)) + 1e-12
    size, axes = np.linalg.eigh((J / scale).T @ (J / scale))
    # In these coordinates the whole information is the unit matrix; a block's share of it has values from 0 to 1.
    known = size > 1e-13 * size.max(initial=0.0)
    turned = axes[:, known] / np.sqrt(size[known]) / scale[:, None]
    J = J @ turned
    losses = np.empty(len(blocks))
    for b, parts in enumerate(blocks):
        rb = np.concatenate([r[part] for part in parts])
        Jb = np.concatenate([J[part] for part in parts])
        share, directions = np.linalg.eigh(Jb.T @ Jb)
        moved = np.where(share < ALONE, 1.0 / (1.0 - np.minimum(share, ALONE)), 0.0)
        step = directions @ (moved * (directions.T @ (Jb.T @ rb)))
        left = rb + Jb @ step * min(1.0, farthest / (np.max(np.abs(turned @ step), initial=0.0) + 1e-300))
        losses[b] = left @ left
    return HeldOut(loss=float(losses.sum()), blocks=losses)
