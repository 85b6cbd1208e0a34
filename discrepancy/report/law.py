"""The named law over what the model without it leaves: measured torque in cells with error bars, and the law's band.

Theory of operation. The torque that the measured motion needs, by inverse dynamics of the model without the effect, is
taken from the torque that the input makes; both pass the same smoothing. What remains is what the effect must have
done, and it owes nothing to the effect's fit. The law itself is drawn over its variable where it depends on that alone;
else the fitted model is simulated and treated like the measurement. Its band follows from the covariance of its
parameters. Joints at rest are left out: what friction does there the motion does not tell.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from discrepancy.data.ranges import measured_speed
from discrepancy.data.series import SPEED, TORQUE, Series
from discrepancy.effects.alone import alone, opposing_torque, with_zero
from discrepancy.effects.spec import Port
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.parameters import FitParameter, clear_effect
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.locate import Place
from discrepancy.report.binning import Samples, bin_samples
from discrepancy.report.pictures import LawPicture
from discrepancy.report.views import VIEWS, Signal, View, signal_of
from discrepancy.search.state import State
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.inverse import torque_record
from discrepancy.simulation.kernels.smoothing import smooth_speed

FloatArray = NDArray[np.float64]

SMOOTH_S = 0.01
EDGE_S = 0.05
REST_SHARE = 0.02
"""Below this part of the largest speed a joint counts as resting."""
BLOCK_S = 2.0
GRID = 401
_SIGMAS = 1.96
_UNIT_OF_ROW = ((SPEED, ("rad/s", "m/s")), (TORQUE, ("N m", "N")))


@dataclass(frozen=True, slots=True, kw_only=True)
class LawMaker:
    """Draws laws of one fitted model.

    Attributes:
        covariance: of the fitted parameters, SI units, shape (p, p).
        linear: whether the axis is linear.
    """

    problem: SimulationProblem
    state: State
    covariance: FloatArray
    linear: bool

    def named(self, name: str) -> LawPicture | None:
        """Return the picture of one effect of the model, None if it is not (any more) part of it."""
        if name not in self.state.present:
            return None
        view, full = VIEWS[name], self.state.fit.vector
        bare = clear_effect(full, EFFECTS[name])
        points = bin_samples(self._samples(view, bare, None))
        if view.exact and all(EFFECTS[other].inverse for other in self.state.present):
            law_x = _grid(points.x)
            law = self._with_band(name, lambda vector: _law_alone(vector, name, law_x, view.x))
        else:
            edges = points.edges
            law_x = points.cells.x
            law = self._with_band(
                name, lambda vector: bin_samples(self._samples(view, bare, vector), edges).cells.mean
            )
        drawn = np.all([np.isfinite(part) for part in law if part.size], axis=0)
        x_name, x_unit, y_unit = self._titles(view)
        return LawPicture(
            x_name=x_name, x_unit=x_unit, y_name=view.what, y_unit=y_unit, points=points.cells,
            law_x=law_x[drawn], law=law[0][drawn],
            low=law[1][drawn] if law[1].size else law[1], high=law[2][drawn] if law[2].size else law[2],
        )  # fmt: skip

    def nameless(self, place: Place) -> LawPicture:
        """Return what the model leaves over the variable of an unknown part, without any law."""
        view = View(x=signal_of(place.driver), output=place.port is Port.SENSOR)
        points = bin_samples(self._samples(view, self.state.fit.vector, None))
        x_name, x_unit, y_unit = self._titles(view)
        what = "error of the output" if view.output else view.what
        return LawPicture(x_name=x_name, x_unit=x_unit, y_name=what, y_unit=y_unit, points=points.cells)

    def _titles(self, view: View) -> tuple[str, str, str]:
        column = 1 if self.linear else 0
        unit = view.unit[column]
        if view.output:
            row = self.problem.series[0].channels[0].row
            unit = dict(_UNIT_OF_ROW).get(row, ("rad", "m"))[column]
        return view.x.value[0], view.x.value[1 + column], unit

    def _with_band(
        self, name: str, evaluate: Callable[[FloatArray], FloatArray]
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the law at the fitted point and its 95 % band by propagating the covariance linearly."""
        vector = self.state.fit.vector
        own = [i for i, p in enumerate(self.state.fit.parameters) if p.owner == name]
        law = evaluate(vector)
        slopes = []
        for i in own:
            parameter = self.state.fit.parameters[i]
            value = float(vector[parameter.slot])
            step = max(0.3 * float(np.sqrt(max(0.0, self.covariance[i, i]))), 1e-6 * abs(value), 1e-12)
            step = _within_bounds(parameter, value, step)
            moved = vector.copy()
            moved[parameter.slot] = value + step
            slopes.append((evaluate(moved) - law) / step)
        if not slopes:
            return law, np.empty(0), np.empty(0)
        slope = np.stack(slopes)
        variance = np.einsum("ik,ij,jk->k", slope, self.covariance[np.ix_(own, own)], slope)
        half = _SIGMAS * np.sqrt(np.maximum(0.0, variance))
        return law, law - half, law + half

    def _samples(self, view: View, bare: FloatArray, simulated: FloatArray | None) -> Samples:
        """Return all samples of a view: measured, or of a model simulated with the vector `simulated`."""
        parts = []
        left_out = self.problem.simulate(self.problem.prepare(bare), self.state.fit.starts)
        vector = self.state.fit.vector if simulated is None else simulated
        outputs = self.problem.simulate(self.problem.prepare(vector), self.state.fit.starts)
        for k, one in enumerate(self.problem.series):
            channel = one.channels[0]
            values = channel.values if simulated is None else outputs[k][channel.row]
            speed = measured_speed(one)
            if simulated is not None and channel.row == SPEED:
                speed = values
            signals = _signals(one, speed, (float(bare[s.OUTPUT_SMOOTHING]), float(bare[s.SMOOTHING_ORDER])))
            y = values - left_out[k][channel.row]
            if channel.row != TORQUE and not view.output:
                y = _missing(one, signals, bare)
            parts.append((one, signals, y))
        return _join(parts, view)


def _within_bounds(parameter: FitParameter, value: float, step: float) -> float:
    """Return a step that keeps a badly known parameter where the model can be simulated, downwards if need be."""
    up, down = parameter.upper - value, value - parameter.lower
    if step <= up or max(up, down) <= 0.0:
        return step
    return up if up >= down else -min(step, down)


def _signals(one: Series, speed: FloatArray, smoothing: tuple[float, float]) -> dict[Signal, FloatArray]:
    """Return all signals smoothed alike; the speed column was smoothed once before, the input was not."""
    width = max(0.5, SMOOTH_S / one.step)
    smooth = np.asarray(gaussian_filter1d(speed, width))
    current = one.input.copy()
    if smoothing[0] > 0.0:
        smooth_speed(current, one.windows, one.step, *smoothing)
    current = np.asarray(gaussian_filter1d(current, width))
    found = {
        Signal.SPEED: smooth,
        Signal.INPUT: current,
        Signal.ACCELERATION: np.asarray(np.gradient(smooth, one.time_s)),
        Signal.SLOPE: np.asarray(np.gradient(current, one.time_s)),
        Signal.TIME: one.time_s,
        Signal.ONE: np.ones(one.n),
        Signal.DIRECTION: np.sign(smooth),
    }
    found[Signal.POSITION] = one.angle if one.angle.size else np.zeros(one.n)
    return found


def _missing(one: Series, signals: dict[Signal, FloatArray], bare: FloatArray) -> FloatArray:
    """Return the torque of the input minus what the motion needs without the effect, shape (n,)."""
    constant = float(bare[s.TORQUE_CONSTANT])
    motion = (signals[Signal.POSITION], signals[Signal.SPEED], signals[Signal.ACCELERATION])
    needed = torque_record(bare, one.time_s, signals[Signal.INPUT], motion, constant)
    return np.asarray(constant * signals[Signal.INPUT] - needed)


def _join(parts: Sequence[tuple[Series, dict[Signal, FloatArray], FloatArray]], view: View) -> Samples:
    top = max(float(np.max(np.abs(signals[Signal.SPEED]))) for _, signals, _ in parts)
    xs, ys, zs, blocks = [], [], [], []
    offset = 0
    for one, signals, y in parts:
        keep = (np.abs(signals[Signal.SPEED]) > REST_SHARE * top) & (one.channels[0].weight > 0)
        keep &= _inside(one)
        block = offset + (one.time_s / BLOCK_S).astype(np.int64)
        offset = int(block[-1]) + 1
        xs.append(signals[view.x][keep])
        ys.append(y[keep])
        zs.append(signals[view.per][keep])
        blocks.append(block[keep])
    return Samples(
        x=np.concatenate(xs), y=np.concatenate(ys), per=np.concatenate(zs), block=np.concatenate(blocks)
    )


def _inside(one: Series) -> NDArray[np.bool_]:
    """Return which samples are far enough from the ends of a window for their smoothing, shape (n,)."""
    margin = 2 + round(EDGE_S / one.step)
    inside = np.zeros(one.n, dtype=np.bool_)
    for a, b in one.edges:
        inside[a + margin : max(a + margin, b - margin)] = True
    return inside


def _grid(x: FloatArray) -> FloatArray:
    return with_zero(np.linspace(float(x.min()), float(x.max()), GRID))


def _law_alone(fitted: FloatArray, name: str, x: FloatArray, signal: Signal) -> FloatArray:
    """Return the opposing torque of one effect alone at speeds or angles `x`."""
    vector = alone(EFFECTS[name], fitted)
    return opposing_torque(vector, angle=x) if signal is Signal.POSITION else opposing_torque(vector, speed=x)
