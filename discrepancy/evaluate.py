"""Score a fitted model on records at their full rate: rmse, nrmse and gap of each output."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.series import POSITION, Series
from discrepancy.fitting.free_run import MOST_WINDOWS, best_free_run
from discrepancy.fitting.problem import Noise, SimulationProblem
from discrepancy.fitting.projection import fit_starts

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """Figures of one output on some records."""

    rmse: float
    nrmse: float
    gap: float

    def to_dict(self) -> dict[str, float]:
        """Return the entry of `outputs` in `gap.json`."""
        return {"rmse": self.rmse, "nrmse": self.nrmse, "gap": self.gap}


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """Measured and simulated output of one record."""

    label: str
    name: str
    time_s: FloatArray
    measured: FloatArray
    simulated: FloatArray
    weight: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Scorer:
    """Computes the curves of the training and the test records for a parameter vector."""

    train: Callable[[FloatArray], list[Curve]]
    test: Callable[[FloatArray], list[Curve]]


def simulation_scorer(train: Sequence[Series], test: Sequence[Series]) -> Scorer:
    """Return the scorer of free-run simulation at full rate."""
    return Scorer(
        train=lambda vector: simulate_series(train, vector), test=lambda vector: simulate_series(test, vector)
    )


def simulate_series(series: Sequence[Series], vector: FloatArray) -> list[Curve]:
    """Simulate records with the windows' starting states fitted, everything else frozen."""
    noise = Noise(
        sigma={channel.name: max(float(np.std(channel.values)), 1e-12) for channel in series[0].channels}
    )
    problem = SimulationProblem(series=tuple(series), noise=noise)
    if any(c.row == POSITION for c in series[0].channels) and len(series[0].windows) <= MOST_WINDOWS:
        free = best_free_run(problem, (), vector)
        return _curves(series, problem.simulate(free.vector, free.starts))
    # A smoothed speed errs at its ends: a record may begin at rest though its first samples say otherwise.
    starts = problem.initial_starts()
    at_rest = tuple(start * np.array([0.0, 1.0]) for start in starts)
    fitted = min((fit_starts(problem, vector, one) for one in (starts, at_rest)), key=lambda one: one.loss)
    return _curves(series, fitted.outputs)


def _curves(series: Sequence[Series], outputs: Sequence[FloatArray]) -> list[Curve]:
    return [
        Curve(
            label=one.label, name=channel.name, time_s=one.time_s, measured=channel.values,
            simulated=output[channel.row], weight=channel.weight,
        )
        for one, output in zip(series, outputs, strict=True)
        for channel in one.channels
    ]  # fmt: skip


def score_curves(curves: Sequence[Curve], noise_floor: Mapping[str, float]) -> dict[str, Score]:
    """Return the figures of each output over all records."""
    found = {}
    for name in dict.fromkeys(curve.name for curve in curves):
        own = [curve for curve in curves if curve.name == name]
        weight = np.concatenate([curve.weight for curve in own]) > 0
        measured = np.concatenate([curve.measured for curve in own])[weight]
        error = measured - np.concatenate([curve.simulated for curve in own])[weight]
        rmse = float(np.sqrt(np.mean(error**2)))
        size = max(float(np.std(measured)), 1e-300)
        gap = float(np.sqrt(max(0.0, rmse**2 - noise_floor.get(name, 0.0) ** 2)) / size)
        found[name] = Score(rmse=rmse, nrmse=rmse / size, gap=gap)
    return found
