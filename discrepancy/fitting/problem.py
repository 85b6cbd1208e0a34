"""A fit's view of the data: parameter vector in, weighted (and whitened) residual out.

The starting speed and angle of each window are nuisance numbers. They are not moved by the search but projected out:
each
window has one or two columns of sensitivities to its start, and residual and Jacobian are made orthogonal to them.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from discrepancy.data.series import POSITION, SPEED, Series
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.joint import simulate_record
from discrepancy.simulation.kernels.smoothing import smooth_speed

FloatArray = NDArray[np.float64]
Starts = tuple[FloatArray, ...]

_START_STEP = 1e-4
STEP_ANGLE = 0.25
"""A sub-step turns the fastest oscillation of the joint by at most this angle, rad."""
COARSE_STEP_ANGLE = 0.6
"""The same where starts are only compared: the frequency is right to 1.5 %."""
SHORTEST_STEP_S = 2e-4
PRELOAD = 3
"""Column of the starting states for what the presliding springs carry beyond the equilibrium at rest, N m."""
TWISTS = (-1.0, -0.5, 0.0, 0.5, 1.0)
"""Where in its gap a joint with play may begin, in half gaps."""


def safe_step(vector: FloatArray, longest: float, angle: float) -> float:
    """Return a sub-step in which the fastest oscillation these parameters can make turns by at most `angle`, rad."""
    inertia = vector[s.INERTIA]
    fastest = 0.0
    if vector[s.LOAD_SHARE] > 0.0:
        share = vector[s.LOAD_SHARE]
        fastest = max(fastest, vector[s.STIFFNESS] / (inertia * share * (1.0 - share)))
    if vector[s.PRESLIDING_LEVEL] > 0.0:
        fastest = max(fastest, vector[s.PRESLIDING_STIFFNESS] / inertia)
    fastest = max(fastest, vector[s.STOP_STIFFNESS] / inertia)
    if fastest <= 0.0:
        return longest
    return max(SHORTEST_STEP_S, min(longest, angle / math.sqrt(fastest)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Noise:
    """What is known about the measurement noise of each output.

    Attributes:
        sigma: standard deviation of a binned sample, by output.
        whitener: coefficients a of the prediction-error filter 1 + a1 z^-1 + ..., by output; absent means white.
    """

    sigma: Mapping[str, float]
    whitener: Mapping[str, FloatArray] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulationProblem:
    """Free-run simulation against measured outputs."""

    series: tuple[Series, ...]
    noise: Noise
    longest_step: float = 8e-3
    step_angle: float = STEP_ANGLE
    edge: int = 0
    """Samples at either end of a record that are left out once whitened."""

    @property
    def counted(self) -> float:
        """Number of samples that a sum of squares stands for; a mean of m repeats counts m times."""
        return float(sum(channel.weight @ channel.weight for one in self.series for channel in one.channels))

    @property
    def rows(self) -> float:
        """Number of flattened samples that are measurements, the expected sum of squares of pure noise."""
        return float(sum(np.count_nonzero(c.weight) for one in self.series for c in one.channels))

    def initial_starts(self) -> Starts:
        """Return the windows' starting states read off the measurement."""
        return tuple(series.starts.copy() for series in self.series)

    def prepare(self, vector: FloatArray) -> FloatArray:
        """Return the vector with the sub-step that it needs."""
        changed = vector.copy()
        changed[s.MAX_STEP] = safe_step(vector, self.longest_step, self.step_angle)
        return changed

    def simulate(self, vector: FloatArray, starts: Starts) -> list[FloatArray]:
        """Return the simulated outputs of each record, shape (3, n)."""
        outputs = []
        for one, start in zip(self.series, starts, strict=True):
            output = simulate_record(vector, one.time_s, one.input, one.angle, one.windows, start)
            if vector[s.OUTPUT_SMOOTHING] > 0.0:
                constant, order = float(vector[s.OUTPUT_SMOOTHING]), float(vector[s.SMOOTHING_ORDER])
                smooth_speed(output[SPEED], one.windows, one.step, constant, order)
            outputs.append(output)
        return outputs

    def flatten(self, outputs: Sequence[FloatArray]) -> FloatArray:
        """Weight, whiten and join what `simulate` returned (or differences of it)."""
        parts = []
        for one, output in zip(self.series, outputs, strict=True):
            for channel in one.channels:
                scaled = output[channel.row] * channel.weight / self.noise.sigma[channel.name]
                whitener = self.noise.whitener.get(channel.name)
                parts.append(scaled if whitener is None else self._whitened(scaled, whitener))
        return np.concatenate(parts)

    def _whitened(self, values: FloatArray, whitener: FloatArray) -> FloatArray:
        filtered = np.asarray(lfilter(whitener, [1.0], values))
        if self.edge:
            filtered[: self.edge] = 0.0
            filtered[-self.edge :] = 0.0
        return filtered

    def measured(self) -> FloatArray:
        """Return the measured outputs in the shape of `flatten`."""
        rows = []
        for one in self.series:
            output = np.zeros((4, one.n))
            for channel in one.channels:
                output[channel.row] = channel.values
            rows.append(output)
        return self.flatten(rows)

    def with_inner_states(self, vector: FloatArray, starts: Starts) -> Starts:
        """Return the starts with the states that nobody measures: the place in the play, and how springs are bent.

        Springs of presliding friction begin in equilibrium with weight and offset, as at rest without current.
        What they carry beyond that, N m, is one more starting state that is projected out.
        """
        if vector[s.GAP] > 0.0:
            return self.with_best_twists(vector, starts)
        width = PRELOAD + 1 if vector[s.PRESLIDING_LEVEL] > 0.0 else 2
        return tuple(
            start if start.shape[1] == width else np.pad(start[:, :2], ((0, 0), (0, width - 2)))
            for start in starts
        )

    def with_best_twists(self, vector: FloatArray, starts: Starts) -> Starts:
        """Return the starts with the place in the gap, in half gaps, from which each fresh window goes on best.

        A joint at rest may lie anywhere in its play. No slope leads there: where it lies decides how often it bounces.
        """
        if vector[s.GAP] <= 0.0:
            return starts
        data = self.measured()
        tried, losses = [], []
        for side in TWISTS:
            tried.append(
                tuple(np.column_stack([start[:, :2], np.full(len(start), side)]) for start in starts)
            )
            with np.errstate(over="ignore", invalid="ignore"):
                left = data - self.flatten(self.simulate(vector, tried[-1]))
            losses.append([sum(float(left[p] @ left[p]) for p in parts) for parts in self.window_slices()])
        best = np.argmin(np.nan_to_num(losses, nan=np.inf), axis=0)
        counts = np.cumsum([0, *(len(start) for start in starts)])
        for i, (a, b) in enumerate(zip(counts[:-1], counts[1:], strict=True)):
            tried[0][i][:, 2] = np.asarray(TWISTS)[best[a:b]]
        return tried[0]

    def start_rows(self, starts: Starts) -> tuple[int, ...]:
        """Return which starting states the outputs reveal: speed, angle where a position is an output, springs."""
        has_position = any(channel.row == POSITION for channel in self.series[0].channels)
        motion = (SPEED, POSITION) if has_position else (SPEED,)
        return (*motion, PRELOAD) if starts[0].shape[1] > PRELOAD else motion

    def start_columns(self, vector: FloatArray, starts: Starts, at: list[FloatArray]) -> list[FloatArray]:
        """Return the sensitivities of the flattened output to all starting speeds, then angles, then springs' loads."""
        columns = []
        for row in self.start_rows(starts):
            size = [_START_STEP * _natural_size(one, row, vector) for one in self.series]
            moved = tuple(start.copy() for start in starts)
            for start, step in zip(moved, size, strict=True):
                start[:, row] += step
            changed = self.simulate(vector, moved)
            columns.append(self.flatten([(b - a) / h for a, b, h in zip(at, changed, size, strict=True)]))
        return columns

    def window_slices(self) -> list[list[slice]]:
        """Return, for each window, the slices of the flattened residual that belong to it (one per channel)."""
        found = []
        offset = 0
        for one in self.series:
            for a, b in one.edges:
                found.append(
                    [slice(offset + c * one.n + a, offset + c * one.n + b) for c in range(len(one.channels))]
                )
            offset += one.n * len(one.channels)
        return found

    def blocks(self, seconds: float) -> list[list[slice]]:
        """Return slices of the flattened residual that belong together in time, for leaving out one at a time."""
        found = []
        offset = 0
        for one in self.series:
            count = max(2, round(one.n * one.step / seconds))
            edges = np.linspace(0, one.n, count + 1).astype(int)
            for a, b in zip(edges[:-1], edges[1:], strict=True):
                found.append(
                    [slice(offset + c * one.n + a, offset + c * one.n + b) for c in range(len(one.channels))]
                )
            offset += one.n * len(one.channels)
        return found


def _natural_size(series: Series, row: int, vector: FloatArray) -> float:
    """Return the size of a starting state: of the springs' load, a tenth of all that they carry."""
    if row == PRELOAD:
        return 0.1 * float(vector[s.PRESLIDING_LEVEL])
    return max(1e-9, float(np.ptp(_channel_values(series, row))))


def _channel_values(series: Series, row: int) -> FloatArray:
    for channel in series.channels:
        if channel.row == row:
            return channel.values
    return np.array([0.0, 1.0])
