"""What a fitted model predicts under an excitation that was not played, and how far a refitted rival stays from it.

For models A and B the data that A predicts are fitted with B's parameters, starting states included, beside the
records that B already explains; what B cannot follow is the predicted distance. In the first look the fit is replaced
by its linearisation (`information.py`).
"""

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
from discrepancy.search.state import State

FloatArray = NDArray[np.float64]

REFIT_ITERATIONS = 5
_WINDOW_S = 1.0
"""Predictions of a chaotic motion are compared in windows of this length."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """Where predictions are made.

    Attributes:
        template: a training record; predictions have its outputs and sample times.
        noise: of one of its samples.
        limits: what the rig allows.
        known: the records so far; a rival has to explain them too.
        step_angle: of the simulation's sub-steps; coarse where candidates are only compared.
    """

    template: Series
    noise: Noise
    limits: RigLimits
    known: tuple[Series, ...] = ()
    step_angle: float = STEP_ANGLE

    def problem(self, *series: Series) -> SimulationProblem:
        """Return the simulation of records, one of which was not played."""
        return SimulationProblem(series=series, noise=self.noise, step_angle=self.step_angle)


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


def time_inside(outputs: FloatArray, step_s: float, limits: RigLimits) -> float:
    """Return how long a predicted motion keeps to the limits, s; one that is not finite does not."""
    speed, position = outputs[SPEED], outputs[POSITION]
    with np.errstate(invalid="ignore"):
        inside = (
            np.all(np.isfinite(outputs[: CURRENT + 1]), axis=0)
            & (np.abs(speed) <= limits.speed)
            & (position >= limits.travel_low)
            & (position <= limits.travel_high)
        )
    return float(inside.size if inside.all() else np.argmin(inside)) * step_s


def with_outputs(blank: Series, outputs: FloatArray, *, in_windows: bool) -> Series:
    """Return the record that a model predicts; in short windows where a free run would be chaotic."""
    channels = tuple(replace(c, values=outputs[c.row]) for c in blank.channels)
    filled = replace(blank, channels=channels, angle=outputs[POSITION].copy())
    return cut_windows(filled, _WINDOW_S) if in_windows else filled


def predict(
    stage: Stage, blank: Series, truth: State, rivals: Sequence[State], least_s: float
) -> tuple[Series, float] | None:
    """Return the record that `truth` predicts and how long all models stay inside what the rig allows, s.

    None if that is less than `least_s`.
    """
    outputs = simulate(stage, blank, truth)
    inside = time_inside(outputs, blank.step, stage.limits)
    least_s -= blank.step  # a record is a whole number of samples
    for one in rivals:
        if inside < least_s:
            return None
        inside = min(inside, time_inside(simulate(stage, blank, one), blank.step, stage.limits))
    if inside < least_s:
        return None
    chaotic = any(one.is_chaotic for one in (truth, *rivals))
    return with_outputs(blank, np.nan_to_num(outputs), in_windows=chaotic), inside


def beside(stage: Stage, predicted: Series, state: State) -> Fit:
    """Return a model beside a prediction, not moved: what it does not follow, and its sensitivities."""
    problem = stage.problem(predicted)
    return fit(problem, state.fit.parameters, state.fit.vector, problem.initial_starts(), 0)


def refitted_distance(stage: Stage, predicted: Series, rival: State) -> float:
    """Return how far the rival, fitted again to all records, stays from a prediction, in noise variances."""
    problem = stage.problem(*stage.known, predicted)
    starts = (*(rival.fit.starts if stage.known else ()), *stage.problem(predicted).initial_starts())
    done = fit(problem, rival.fit.parameters, rival.fit.vector, starts, REFIT_ITERATIONS)
    new = done.residual[-predicted.n * len(predicted.channels) :]
    on_new = float(new @ new)
    # A rival that had not been fitted to the end explains the old records better now: no merit of the new one.
    return on_new + max(0.0, done.loss - on_new - rival.fit.loss) if stage.known else on_new
