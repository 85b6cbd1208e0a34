"""What a fitted model predicts under an excitation that was not played, and how far a refitted rival stays from it.

For models A and B the data that A predicts are fitted with B's parameters, starting states included; what B cannot
follow is the predicted distance (T-optimality: A. C. Atkinson, V. V. Fedorov, Biometrika 62(1), 1975). In the first
look the fit is replaced by its linearisation, which costs one simulation for each parameter.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.series import CURRENT, POSITION, SPEED, Series, cut_windows
from discrepancy.design.excitations import waveform
from discrepancy.design.limits import RigLimits
from discrepancy.fitting.levenberg import Fit, fit
from discrepancy.fitting.problem import STEP_ANGLE, Noise, SimulationProblem
from discrepancy.search.state import CHAOTIC_WINDOW_S, State

FloatArray = NDArray[np.float64]

REFIT_ITERATIONS = 5
_RIDGE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """Where predictions are made.

    Attributes:
        template: a training record; predictions have its outputs and sample times.
        noise: of one of its samples.
        limits: what the rig allows.
        step_angle: of the simulation's sub-steps; coarse where candidates are only compared.
    """

    template: Series
    noise: Noise
    limits: RigLimits
    step_angle: float = STEP_ANGLE

    def problem(self, series: Series) -> SimulationProblem:
        """Return the simulation of a record that was not played."""
        return SimulationProblem(series=(series,), noise=self.noise, step_angle=self.step_angle)


def blank_series(stage: Stage, excitation: Mapping[str, Any], duration_s: float) -> Series:
    """Return a record with this input in which nothing has been measured yet, at rest at the start."""
    template = stage.template
    values = waveform(excitation, duration_s, template.step)
    zeros = np.zeros(values.size)
    return Series(
        label="predicted", step=template.step, original_step=template.original_step,
        time_s=np.arange(values.size, dtype=np.float64) * template.step, input=values, angle=np.empty(0),
        channels=tuple(replace(c, values=zeros, weight=np.ones(values.size)) for c in template.channels),
        windows=np.array([-1], dtype=np.int64), starts=np.zeros((1, 2)),
    )  # fmt: skip


def simulate(stage: Stage, blank: Series, state: State) -> FloatArray:
    """Return what a model predicts, rows speed, position and current, shape (3, n)."""
    problem = stage.problem(blank)
    return problem.simulate(problem.prepare(state.fit.vector), problem.initial_starts())[0]


def stays_inside(outputs: FloatArray, limits: RigLimits) -> bool:
    """Return whether a predicted motion keeps to the limits; one that is not finite does not."""
    speed, position = outputs[SPEED], outputs[POSITION]
    return bool(
        np.all(np.isfinite(outputs[: CURRENT + 1]))
        and np.max(np.abs(speed)) <= limits.speed
        and np.min(position) >= limits.travel_low
        and np.max(position) <= limits.travel_high
    )


def with_outputs(blank: Series, outputs: FloatArray, *, in_windows: bool) -> Series:
    """Return the record that a model predicts; in short windows where a free run would be chaotic."""
    channels = tuple(replace(c, values=outputs[c.row]) for c in blank.channels)
    filled = replace(blank, channels=channels, angle=outputs[POSITION].copy())
    return cut_windows(filled, CHAOTIC_WINDOW_S) if in_windows else filled


def predict(stage: Stage, blank: Series, truth: State, rivals: Sequence[State]) -> Series | None:
    """Return the record that `truth` predicts, None if it or a rival would leave what the rig allows."""
    outputs = simulate(stage, blank, truth)
    if not stays_inside(outputs, stage.limits):
        return None
    if not all(stays_inside(simulate(stage, blank, one), stage.limits) for one in rivals):
        return None
    return with_outputs(blank, outputs, in_windows=any(one.is_chaotic for one in (truth, *rivals)))


def linear_distance(stage: Stage, predicted: Series, rival: State) -> float:
    """Return how far the rival stays from a prediction after one linear fit, in noise variances."""
    done = _fitted(stage, predicted, rival, 0)
    if not done.parameters:
        return done.loss
    normal = done.normal()
    scale = np.sqrt(np.diag(normal)) + 1e-12
    gradient = done.jacobian.T @ done.residual / scale
    moved = np.linalg.lstsq(normal / np.outer(scale, scale), gradient, rcond=1e-10)[0]
    return max(0.0, done.loss - float(gradient @ moved))


def refitted_distance(stage: Stage, predicted: Series, rival: State) -> float:
    """Return how far the refitted rival stays from a prediction, in noise variances."""
    return _fitted(stage, predicted, rival, REFIT_ITERATIONS).loss


def _fitted(stage: Stage, predicted: Series, rival: State, iterations: int) -> Fit:
    problem = stage.problem(predicted)
    return fit(problem, rival.fit.parameters, rival.fit.vector, problem.initial_starts(), iterations)


def worst_error(stage: Stage, predicted: Series | None, state: State, owner: str) -> float:
    """Return the largest relative standard error of an effect's parameters, with or without one more record."""
    information = state.fit.normal()
    if predicted is not None:
        information = information + _fitted(stage, predicted, state, 0).normal()
    covariance = np.linalg.pinv(information + _RIDGE * np.eye(len(information)), rcond=1e-14)
    worst = 0.0
    for i, parameter in enumerate(state.fit.parameters):
        if parameter.owner == owner:
            value = float(state.fit.vector[parameter.slot])
            error = math.sqrt(max(0.0, float(covariance[i, i]))) * parameter.slope(value)
            worst = max(worst, error / max(abs(value), 1e-12))
    return worst
