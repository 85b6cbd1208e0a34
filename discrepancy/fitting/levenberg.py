"""Bounded Levenberg-Marquardt in scaled coordinates, with the windows' starting states projected out.

Written here instead of using a library's because the projection and the forward differences on the compiled
simulation are
the hot path: a step costs one simulation a parameter. Reference: J. J. More, The Levenberg-Marquardt algorithm, 1978.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discrepancy.fitting.parameters import FitParameter
from discrepancy.fitting.problem import SimulationProblem, Starts
from discrepancy.fitting.projection import QUIET, STEEPEST, Point, Projector, bounded, moved_starts
from discrepancy.simulation import slots as s

FloatArray = NDArray[np.float64]

_DIFFERENCE = 3e-4
COARSE_DIFFERENCE = 3e-2
"""Play makes the loss rough: it is smooth only over steps that are larger than single contacts."""
_TOLERANCE = 3e-5


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """A fitted point.

    Attributes:
        vector: the kernel's parameter vector.
        starts: starting states of all windows.
        residual: flattened, whitened, starts projected out, shape (N,).
        jacobian: of the residual in scaled coordinates, projected likewise, shape (N, p); of the last iteration.
        loss: sum of squares of the residual.
    """

    parameters: tuple[FitParameter, ...]
    vector: FloatArray
    starts: Starts
    residual: FloatArray
    jacobian: FloatArray
    loss: float
    iterations: int

    @property
    def values(self) -> FloatArray:
        """Fitted values in SI units, shape (p,)."""
        return np.array([self.vector[p.slot] for p in self.parameters])

    def normal(self) -> FloatArray:
        """Return the information matrix in scaled coordinates, shape (p, p)."""
        return np.asarray(self.jacobian.T @ self.jacobian)

    def covariance(self) -> FloatArray:
        """Return the covariance of the values in SI units, shape (p, p), residual variance as found."""
        p = len(self.parameters)
        if p == 0:
            return np.zeros((0, 0))
        slope = np.array([q.slope(float(self.vector[q.slot])) for q in self.parameters])
        variance = self.loss / max(1, self.residual.size - p)
        return np.asarray(np.linalg.pinv(self.normal(), rcond=1e-14) * np.outer(slope, slope) * variance)


@QUIET
def start_projector(problem: SimulationProblem, at: Fit) -> Projector:
    """Return what removes from flattened values what the starting states at a fitted point can explain."""
    return Projector(problem, Point(problem, problem.measured(), at.vector, at.starts))


def _jacobian(
    problem: SimulationProblem,
    point: Point,
    parameters: Sequence[FitParameter],
    projector: Projector,
    reuse: FloatArray | None,
) -> FloatArray:
    """Return d simulated / d coordinate by forward differences, starts projected out, shape (N, p)."""
    at = problem.flatten(point.outputs)
    columns = np.empty((at.size, len(parameters)))
    known = 0 if reuse is None else reuse.shape[1]
    if reuse is not None:
        columns[:, :known] = reuse
    for i, parameter in enumerate(parameters):
        if i < known:
            continue
        z = parameter.encode(float(point.vector[parameter.slot]))
        h = COARSE_DIFFERENCE if point.vector[s.GAP] > 0.0 else _DIFFERENCE
        if parameter.decode(z + h) >= parameter.upper:
            h = -h
        vector = point.vector.copy()
        vector[parameter.slot] = parameter.decode(z + h)
        columns[:, i] = (problem.flatten(problem.simulate(vector, point.starts)) - at) / h
    return projector.project(bounded(columns, STEEPEST))


def _step(jacobian: FloatArray, residual: FloatArray, damping: float, free: NDArray[np.bool_]) -> FloatArray:
    """Return the damped Gauss-Newton step of the free coordinates."""
    step = np.zeros(jacobian.shape[1])
    if not free.any():
        return step
    J = jacobian[:, free]
    normal = J.T @ J
    scale = np.sqrt(np.diag(normal)) + 1e-12
    scaled = normal / np.outer(scale, scale) + damping * np.eye(len(scale))
    # Not `solve`: a direction that the outputs do not show must stay, and in a chaotic motion rounding decides.
    step[free] = np.linalg.lstsq(scaled, (J.T @ residual) / scale, rcond=1e-12)[0] / scale
    return step


def _free(point: Point, parameters: Sequence[FitParameter], gradient: FloatArray) -> NDArray[np.bool_]:
    """Mark coordinates that are not pressed against a bound."""
    free = np.ones(len(parameters), dtype=np.bool_)
    for i, parameter in enumerate(parameters):
        value = float(point.vector[parameter.slot])
        free[i] = not (
            (value <= parameter.lower and gradient[i] <= 0.0)
            or (value >= parameter.upper and gradient[i] >= 0.0)
        )
    return free


def fit(
    problem: SimulationProblem,
    parameters: Sequence[FitParameter],
    vector: FloatArray,
    starts: Starts,
    iterations: int = 15,
) -> Fit:
    """Fit `parameters` from `vector`; everything else in it stays.

    Args:
        problem: data and noise.
        parameters: what may move.
        vector: starting values.
        starts: starting states of the windows.
        iterations: most Gauss-Newton steps.
    """
    return _fit(problem, parameters, (vector, starts), iterations, None)


def glance(
    problem: SimulationProblem,
    parameters: Sequence[FitParameter],
    at: tuple[FloatArray, Starts],
    iterations: int,
    reuse: FloatArray | None,
) -> Fit:
    """Fit for a few steps, to compare starts: the Jacobian stays that of the last step.

    Args:
        problem: data and noise.
        parameters: what may move.
        at: starting values, and starting states of the windows.
        iterations: most Gauss-Newton steps, at least one.
        reuse: Jacobian of the first parameters at a nearby point, shape (N, k); spares their simulations.
    """
    return _fit(problem, parameters, at, iterations, _Scan(reuse))


@dataclass(frozen=True, slots=True)
class _Scan:
    """Marks a fit of which only parameters and loss are asked; `reuse` as `glance` takes it."""

    reuse: FloatArray | None


@QUIET
def _fit(
    problem: SimulationProblem,
    parameters: Sequence[FitParameter],
    at: tuple[FloatArray, Starts],
    iterations: int,
    scan: _Scan | None,
) -> Fit:
    vector, starts = at
    reuse = None if scan is None else scan.reuse
    data, vector = problem.measured(), problem.prepare(vector)
    point = Point(problem, data, vector, problem.with_inner_states(vector, starts))
    damping = 1e-3
    done = 0
    while True:
        projector = Projector(problem, point)
        residual = projector.project(point.raw)
        jacobian = _jacobian(problem, point, parameters, projector, reuse)
        loss = float(residual @ residual)
        if done >= iterations:
            break
        done += 1
        better, damping = _descend(problem, data, (point, projector, residual, jacobian), parameters, damping)
        if better is None:
            break
        gain = loss - better[1]
        point = better[0]
        if gain <= _TOLERANCE * loss or (scan is not None and done >= iterations):
            projector = Projector(problem, point)
            residual = projector.project(point.raw)
            loss = float(residual @ residual)
            break
    return Fit(
        parameters=tuple(parameters), vector=point.vector, starts=point.starts, residual=residual,
        jacobian=jacobian, loss=loss, iterations=done,
    )  # fmt: skip


def _descend(
    problem: SimulationProblem,
    data: FloatArray,
    at: tuple[Point, Projector, FloatArray, FloatArray],
    parameters: Sequence[FitParameter],
    damping: float,
) -> tuple[tuple[Point, float] | None, float]:
    """Try steps with growing damping until one lowers the loss."""
    point, projector, residual, jacobian = at
    loss = float(residual @ residual)
    free = _free(point, parameters, jacobian.T @ residual)
    for _ in range(6):
        step = np.clip(_step(jacobian, residual, damping, free), -2.0, 2.0)
        vector = point.vector.copy()
        for i, parameter in enumerate(parameters):
            z = parameter.encode(float(vector[parameter.slot])) + step[i]
            vector[parameter.slot] = parameter.decode(z)
        # The starts follow the step linearly: what the moved parameters leave for them to explain.
        changes = projector.coefficients(point.raw - jacobian @ step)
        moved = moved_starts(problem, point.starts, changes)
        trial = Point(problem, data, problem.prepare(vector), moved)
        value = projector.project(trial.raw)
        trial_loss = float(value @ value)
        if trial_loss < loss:
            return (trial, trial_loss), max(damping * 0.2, 1e-9)
        damping = max(damping * 8.0, 1e-4)
    return None, damping
