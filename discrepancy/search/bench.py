"""A finished model under both noise models, beside which further columns of sensitivities are judged."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from discrepancy.effects.spec import Ranges
from discrepancy.fitting.levenberg import Fit
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.context import Context
from discrepancy.search.judge import held_out
from discrepancy.search.noise import noise_beside
from discrepancy.search.outputs import output_losses, output_rows
from discrepancy.search.state import State, refit

FloatArray = NDArray[np.float64]

_RANK = 3e-7


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """What further columns of sensitivities would gain.

    Attributes:
        fall: fall of the held-out loss in noise variances.
        closed: closed part of the gap by output, rms in units of one sample's noise, shape (C,).
    """

    fall: float
    closed: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Bench:
    """The final model under both noise models: `sharp` decides what is significant, `white` what is material."""

    problem: SimulationProblem
    state: State
    sharp_problem: SimulationProblem
    sharp: Fit
    unit: float
    context: Context

    @property
    def excess(self) -> FloatArray:
        """What the model leaves beyond the noise, rms by output in units of one sample's noise, shape (C,)."""
        losses = output_losses(self.problem, self.state.fit.residual)
        return self.context.rms(self.problem, losses - output_rows(self.problem))

    def judge(self, sharp: FloatArray, white: FloatArray, without: tuple[int, ...] = ()) -> Judgement:
        """Judge columns of sensitivities, shape (N, k), beside the model's own (less those listed in `without`)."""
        keep = [i for i in range(self.sharp.jacobian.shape[1]) if i not in without]
        own = _at_optimum(self.sharp, self.sharp.jacobian[:, keep])
        more = _at_optimum(self.sharp, np.concatenate([self.sharp.jacobian[:, keep], sharp], axis=1))
        fall = held_out(self.sharp_problem, own).loss - held_out(self.sharp_problem, more).loss
        fit = self.state.fit
        before = _at_optimum(fit, fit.jacobian[:, keep])
        after = _at_optimum(fit, np.concatenate([before.jacobian, white], axis=1))
        gained = [output_losses(self.problem, one.residual) for one in (before, after)]
        by_chance = white.shape[1] * self.unit
        closed = self.context.rms(self.problem, gained[0] - gained[1] - by_chance)
        return Judgement(fall=float(fall / self.unit), closed=closed)


def _at_optimum(fit: Fit, columns: FloatArray) -> Fit:
    """Return the linearised fit of these columns of sensitivities to what the fit has left."""
    scaled = columns / (np.linalg.norm(columns, axis=0) + 1e-300)
    left = fit.residual
    for _ in range(2):  # the second pass takes away what rounding in the normal equations left
        left = left - scaled @ solve_by_rank(scaled, left, _RANK)
    return replace(fit, jacobian=scaled, residual=left, loss=float(left @ left))


def solve_by_rank(columns: FloatArray, values: FloatArray, rank: float) -> FloatArray:
    """Return the shortest least-squares solution, shape (k,); singular values below `rank` of the largest are zero.

    By the normal equations: columns, shape (N, k), are few and long, and a singular value decomposition of them all
    costs ten times as much.
    """
    power, turned = np.linalg.eigh(columns.T @ columns)
    kept = power > rank**2 * power[-1]
    turned = turned[:, kept]
    return np.asarray(turned @ ((turned.T @ (columns.T @ values)) / power[kept]))


def make_bench(problem: SimulationProblem, state: State, ranges: Ranges, context: Context) -> Bench:
    """Fit the model again under both noise models."""
    sharp = replace(problem, noise=noise_beside(problem, state, context.repeat_noise, context.pairs))
    again, white = refit(sharp, state, ranges, 3), refit(problem, state, ranges, 3)
    unit = again.fit.loss / problem.rows
    return Bench(
        problem=problem, state=white, sharp_problem=sharp, sharp=again.fit,
        unit=max(1.0, unit) if context.repeat_noise else unit, context=context,
    )  # fmt: skip
