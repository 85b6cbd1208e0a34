"""Could the named laws be the nearest ones in the catalogue, and not the right ones? Two signs of it.

A curve over a variable that is not theirs would still be admitted as an effect, or a fitted parameter is pressed to
its bound and leaving it would be. Both are judged as every effect is: by the held-out loss, in the same noise, with the
same limits of significance and materiality. Nothing here has a threshold of its own. At a bound that says what these
records can show (`Effect.limits`: a level that the motor never overcame) significance alone decides: the law was seen
only where it is another, simpler one.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

from discrepancy.data.series import SPEED, Series
from discrepancy.effects.spec import Port, Ranges
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.levenberg import Fit, project_starts
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.locate import Place, hat_basis, spread_knots
from discrepancy.search.greedy import Context, noise_from
from discrepancy.search.judge import held_out
from discrepancy.search.options import SearchOptions
from discrepancy.search.state import State, refit
from discrepancy.simulation import slots as s

FloatArray = NDArray[np.float64]

_SLOPE_S = 0.01
"""The slope of the input is taken over this time."""
_DRIFT_KNOTS = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """What further columns of sensitivities would gain.

    Attributes:
        fall: fall of the held-out loss in noise variances.
        closed: closed part of the gap, rms in units of one sample's noise.
    """

    fall: float
    closed: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Bench:
    """The final model under both noise models: `sharp` decides what is significant, `white` what is material."""

    problem: SimulationProblem
    state: State
    sharp_problem: SimulationProblem
    sharp: Fit
    unit: float
    bin_size: float

    def judge(self, sharp: FloatArray, white: FloatArray, without: tuple[int, ...] = ()) -> Judgement:
        """Judge columns of sensitivities, shape (N, k), beside the model's own (less those listed in `without`)."""
        keep = [i for i in range(self.sharp.jacobian.shape[1]) if i not in without]
        own = _at_optimum(self.sharp, self.sharp.jacobian[:, keep])
        more = _at_optimum(self.sharp, np.concatenate([self.sharp.jacobian[:, keep], sharp], axis=1))
        fall = held_out(self.sharp_problem, own).loss - held_out(self.sharp_problem, more).loss
        fit = self.state.fit
        before = _at_optimum(fit, fit.jacobian[:, keep])
        gained = before.loss - _at_optimum(fit, np.concatenate([before.jacobian, white], axis=1)).loss
        by_chance = white.shape[1] * self.unit
        closed = np.sqrt(max(0.0, gained - by_chance) / fit.residual.size / self.bin_size)
        return Judgement(fall=float(fall / self.unit), closed=float(closed))


def _at_optimum(fit: Fit, columns: FloatArray) -> Fit:
    """Return the linearised fit of these columns of sensitivities to what the fit has left."""
    scaled = columns / (np.linalg.norm(columns, axis=0) + 1e-300)
    left = fit.residual - scaled @ np.linalg.lstsq(scaled, fit.residual, rcond=1e-9)[0]
    return replace(fit, jacobian=scaled, residual=left, loss=float(left @ left))


def find_doubt(
    problem: SimulationProblem,
    state: State,
    rest: tuple[Ranges, SearchOptions, Context],
    names: Mapping[str, str],
) -> Place | None:
    """Return where the named laws fail, or None if nothing speaks against them.

    Args:
        problem: judged by simulated speed, with white noise weights.
        state: the final model.
        rest: sizes of the signals, limits, and the search's context with all that it has closed.
        names: column names of the drivers.
    """
    ranges, options, context = rest
    bench = _bench(problem, state, ranges, context)
    chaotic = "backlash" in state.present
    tolerance = options.chaotic_form_error if chaotic else options.form_error
    material = max(options.material_noise, tolerance * context.closed)

    def admits(found: Judgement, size: int) -> bool:
        return found.fall > options.alarm + options.per_parameter * size and found.closed > material

    curves = _curves(bench, names)
    # The right law with slightly wrong constants leaves a curve over its own variable; the wrong law leaves others too.
    own = {EFFECTS[name].driver for name in state.present}
    if any(admits(judged, size) for place, judged, size in curves if not _called(place, names) & own):
        return max((place for place, _, _ in curves), key=lambda place: place.share)
    for i in pressed(bench.state.fit, state.added):
        effect, parameter = EFFECTS[state.fit.parameters[i].owner], state.fit.parameters[i].name
        judged = bench.judge(bench.sharp.jacobian[:, [i]], bench.state.fit.jacobian[:, [i]], (i,))
        unseen = effect.limits is not None and parameter in effect.limits(ranges)
        if admits(judged, 1) or (unseen and judged.fall > options.alarm):
            return Place(port=effect.port, driver=effect.driver, region=None, share=_share(bench, judged))
    return None


def pressed(fit: Fit, owners: tuple[str, ...]) -> list[int]:
    """Return which parameters of these effects sit on a bound that the data would cross."""
    gradient = fit.jacobian.T @ fit.residual
    found = []
    for i, p in enumerate(fit.parameters):
        value, near = float(fit.vector[p.slot]), 1e-6
        below = value <= p.lower + near * max(abs(p.lower), near) and gradient[i] < 0.0
        above = value >= p.upper - near * abs(p.upper) and gradient[i] > 0.0
        if p.owner in owners and (below or above):
            found.append(i)
    return found


def _bench(problem: SimulationProblem, state: State, ranges: Ranges, context: Context) -> Bench:
    sharp = replace(problem, noise=context.repeat_noise or noise_from(problem, state))
    again, white = refit(sharp, state, ranges, 3), refit(problem, state, ranges, 3)
    unit = again.fit.loss / again.fit.residual.size
    return Bench(
        problem=problem, state=white, sharp_problem=sharp, sharp=again.fit,
        unit=max(1.0, unit) if context.repeat_noise else unit, bin_size=context.bin_size,
    )  # fmt: skip


def _share(bench: Bench, judged: Judgement) -> float:
    fit = bench.state.fit
    excess = max(0.0, fit.loss / fit.residual.size - 1.0) / bench.bin_size
    return float(min(1.0, judged.closed**2 / max(excess, 1e-300)))


def _curves(bench: Bench, names: Mapping[str, str]) -> list[tuple[Place, Judgement, int]]:
    """Judge a curve over each variable."""
    state, problem = bench.state, bench.problem
    outputs = problem.simulate(state.fit.vector, state.fit.starts)
    signals = [_signals(one, out[SPEED]) for one, out in zip(problem.series, outputs, strict=True)]
    found = []
    for key, port, driver in _DRIVERS:
        column = names.get(driver, driver)
        if key not in signals[0]:
            continue
        knots, torques = _torques(key, signals)
        responses = [
            _response(one, out[SPEED], torque, state.fit.vector)
            for one, out, torque in zip(problem.series, outputs, torques, strict=True)
        ]
        white = project_starts(problem, state.fit, _flat(problem, responses))
        sharp = project_starts(bench.sharp_problem, bench.sharp, _flat(bench.sharp_problem, responses))
        judged = bench.judge(sharp, white)
        place = Place(
            port=port, driver=column, region=None, share=_share(bench, judged),
            shape=_shape(knots, white, state.fit),
        )  # fmt: skip
        found.append((place, judged, white.shape[1]))
    return found


_DRIVERS = (
    ("speed", Port.TORQUE, "speed"),
    ("position", Port.TORQUE, "position"),
    ("input", Port.TORQUE, "input"),
    ("acceleration", Port.TORQUE, "acceleration"),
    ("time", Port.TORQUE, "time"),
    ("slope", Port.CURRENT, "frequency"),
)


def _called(place: Place, names: Mapping[str, str]) -> set[str]:
    """Return what the catalogue may call a place's driver, whatever axis and input the recording has."""
    key = next((key for key, column in names.items() if column == place.driver), "")
    return {place.driver, *_CATALOGUE.get(key, ())}


_CATALOGUE = {
    "speed": ("speed_rad_s",), "position": ("position_rad",), "acceleration": ("acceleration_rad_s2",),
    "input": ("current_A", "current_ref_A"),
}  # fmt: skip


def _signals(one: Series, speed: FloatArray) -> dict[str, FloatArray]:
    width = max(0.5, _SLOPE_S / one.step)
    # The simulated motion: a noisy measured one would share its noise with the residual.
    found = {
        "speed": speed,
        "input": one.input,
        "acceleration": np.asarray(np.gradient(speed, one.time_s)),
        "time": one.time_s,
        "slope": np.asarray(np.gradient(gaussian_filter1d(one.input, width), one.time_s)),
    }
    if one.angle.size:
        found["position"] = one.angle
    return found


def _torques(key: str, signals: list[dict[str, FloatArray]]) -> tuple[FloatArray, list[FloatArray]]:
    """Return the knots of a curve over a variable, and for each record the torques of its parts, shape (n, k)."""
    x = np.concatenate([one[key] for one in signals])
    if key == "slope":
        top = float(np.max(np.abs(x)))
        return np.array([top]), [one[key][:, None] / top for one in signals]
    if key != "time":
        knots = spread_knots(x)
        return knots, [hat_basis(one[key], knots) for one in signals]
    knots = np.linspace(float(x.min()), float(x.max()), _DRIFT_KNOTS)
    hats = [hat_basis(one[key], knots) for one in signals]
    return knots, [
        np.concatenate([hat * one["speed"][:, None], hat * one["input"][:, None]], axis=1)
        for hat, one in zip(hats, signals, strict=True)
    ]


def _response(one: Series, speed: FloatArray, torque: FloatArray, vector: FloatArray) -> FloatArray:
    """Return how torques (n, k) move the speed of the linear joint, shape (n, k); at rest they do not."""
    found = np.zeros_like(torque)
    rate = float(vector[s.VISCOUS] / vector[s.INERTIA])
    decay = float(np.exp(-rate * one.step))
    gain = one.step * 0.5 * (1.0 + decay) / float(vector[s.INERTIA])
    moving = torque * (speed != 0.0)[:, None]
    for a, b in one.edges:
        found[a:b] = lfilter([0.0, gain], [1.0, -decay], moving[a:b], axis=0)
    return found


def _flat(problem: SimulationProblem, responses: list[FloatArray]) -> FloatArray:
    """Weight and whiten speed responses as the residual was, shape (N, k)."""
    columns = []
    for k in range(responses[0].shape[1]):
        outputs = [np.zeros((4, response.shape[0])) for response in responses]
        for output, response in zip(outputs, responses, strict=True):
            output[SPEED] = response[:, k]
        columns.append(problem.flatten(outputs))
    return np.stack(columns, axis=1)


def _shape(knots: FloatArray, columns: FloatArray, fit: Fit) -> tuple[tuple[float, float], ...]:
    joined = np.concatenate([columns, fit.jacobian], axis=1)
    scale = np.linalg.norm(joined, axis=0) + 1e-300
    heights = np.linalg.lstsq(joined / scale, fit.residual, rcond=1e-9)[0] / scale
    return tuple((float(x), float(y)) for x, y in zip(knots, heights[: knots.size], strict=True))
