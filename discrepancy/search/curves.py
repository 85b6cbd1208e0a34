"""What a curve over one variable would gain beside a model: judged as every effect is, by the held-out loss.

A curve is a torque over speed, angle, input, acceleration or time, sent through the linear joint to the outputs; a
curve of the reading itself (sensor); or, where the current is an output, a curve of the current over its reference.
Variables are taken from the simulation: a noisy measured one would share its noise with the residual.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

from discrepancy.data.series import CURRENT, POSITION, SPEED, Series
from discrepancy.effects.spec import Port
from discrepancy.fitting.levenberg import Fit, start_projector
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.fitting.projection import Projector
from discrepancy.locate import KNOTS, Place, hat_basis, region_of, spread_knots
from discrepancy.search.bench import Bench, Judgement, solve_by_rank
from discrepancy.simulation import slots as s

FloatArray = NDArray[np.float64]

_SLOPE_S = 0.01
"""The slope of the input is taken over this time."""
_DRIFT_KNOTS = 5
FEW_KNOTS = 6
_UNDIVIDED = frozenset({"time", "uneven", "slope"})
"""Signals whose curves have a number of knots of their own, and no region."""
_SHAPE_RANK = 3e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """A judged curve of `size` free heights."""

    place: Place
    judged: Judgement
    size: int


def share_of(bench: Bench, judged: Judgement) -> float:
    """Return the part of the excess error that a judged curve closes, 0 to 1, of the output of which it closes most."""
    c = int(np.argmax(judged.closed))
    return float(min(1.0, (judged.closed[c] / max(bench.excess[c], 1e-150)) ** 2))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Axis:
    """One way to draw a curve: which signal, how it acts, the catalogue's word for it, and how many knots at most."""

    key: str
    port: Port
    driver: str
    knots: int


@dataclass(frozen=True, slots=True, kw_only=True)
class _Motion:
    """The simulated motion of all records, and what removes the starting states from columns beside it."""

    signals: list[dict[str, FloatArray]]
    outputs: list[FloatArray]
    white: Projector
    sharp: Projector


def judge_curves(bench: Bench, names: Mapping[str, str]) -> list[Curve]:
    """Judge a curve over each variable; those that predict come first, the one that closes most before the others.

    Each is drawn with few knots and with many, and counts as the one that predicts better: many knots follow a law that
    bends sharply, few stay where only one stretch of a record has been.
    """
    problem = bench.problem
    outputs = problem.simulate(bench.state.fit.vector, bench.state.fit.starts)
    signals = [_signals(one, out) for one, out in zip(problem.series, outputs, strict=True)]
    motion = _Motion(
        signals=signals, outputs=outputs,
        white=start_projector(problem, bench.state.fit),
        sharp=start_projector(bench.sharp_problem, bench.sharp),
    )  # fmt: skip
    rows = {channel.row for channel in problem.series[0].channels}
    found = []
    for key, port, driver in _DRIVERS:
        if key not in signals[0] or not _is_shown(port, key, rows):
            continue
        counts = (KNOTS,) if key in _UNDIVIDED else (KNOTS, FEW_KNOTS)
        axes = [_Axis(key=key, port=port, driver=names.get(driver, driver), knots=count) for count in counts]
        drawn = [_judge_curve(bench, motion, axis) for axis in axes]
        known = [curve for curve in drawn if curve is not None]
        if known:
            found.append(max(known, key=lambda curve: curve.judged.fall))
    return sorted(found, key=lambda c: (c.judged.fall <= 0.0, -float(np.linalg.norm(c.judged.closed))))


def _is_shown(port: Port, key: str, rows: set[int]) -> bool:
    """Return whether the outputs show this curve: one of the current over its reference takes a measured current."""
    return port is not Port.CURRENT or key != "input" or CURRENT in rows


def _judge_curve(bench: Bench, motion: _Motion, axis: _Axis) -> Curve | None:
    """Judge one curve; None where the outputs do not show it."""
    state, problem = bench.state, bench.problem
    knots, parts = _parts(axis.key, motion.signals, axis.knots)
    responses = [
        _responses(one, out, part, (axis.port, axis.key, state.fit.vector))
        for one, out, part in zip(problem.series, motion.outputs, parts, strict=True)
    ]
    white = motion.white.project(flat_columns(problem, responses))
    if not np.any(white):
        return None
    sharp = motion.sharp.project(flat_columns(bench.sharp_problem, responses))
    judged = bench.judge(sharp, white)
    shape = _shape(knots, white, state.fit)
    if axis.key == "uneven":
        # Drawn is what has come at the largest input by the end.
        shape = ((shape[0][0], 0.0), (shape[1][0], shape[0][1]))
    region = None
    if axis.key not in _UNDIVIDED:
        x = np.concatenate([one[axis.key] for one in motion.signals])
        region = region_of(x, np.interp(x, knots, [y for _, y in shape]) ** 2)
    place = Place(
        port=axis.port, driver=axis.driver, region=region, share=share_of(bench, judged), shape=shape
    )
    return Curve(place=place, judged=judged, size=white.shape[1])


_DRIVERS = (
    ("speed", Port.TORQUE, "speed"),
    ("position", Port.TORQUE, "position"),
    ("dry", Port.TORQUE, "position"),
    ("input", Port.TORQUE, "input"),
    ("acceleration", Port.TORQUE, "acceleration"),
    ("time", Port.TORQUE, "time"),
    ("uneven", Port.TORQUE, "time"),
    ("slope", Port.CURRENT, "frequency"),
    ("input", Port.CURRENT, "input"),
    ("speed", Port.SENSOR, "speed"),
    ("position", Port.SENSOR, "position"),
)


def law_responses(
    problem: SimulationProblem, vector: FloatArray, outputs: list[FloatArray]
) -> list[list[dict[int, FloatArray]]]:
    """Return how free curves over each variable move the outputs, for each variable record by record.

    Args:
        problem: the records.
        vector: the model beside which the curves act.
        outputs: what it simulates.

    Returns:
        For each variable and record the outputs' change by row, shape (n, k) for k heights of its curve.
    """
    signals = [_signals(one, out) for one, out in zip(problem.series, outputs, strict=True)]
    rows = {channel.row for channel in problem.series[0].channels}
    found = []
    for key, port, _ in _DRIVERS:
        if key not in signals[0] or key == "uneven" or not _is_shown(port, key, rows):
            continue
        _, parts = _parts(key, signals, KNOTS)
        found.append(
            [
                _responses(one, out, part, (port, key, vector))
                for one, out, part in zip(problem.series, outputs, parts, strict=True)
            ]
        )
    return found


def called(place: Place, names: Mapping[str, str]) -> set[str]:
    """Return what the catalogue may call a place's driver, whatever axis and input the recording has."""
    key = next((key for key, column in names.items() if column == place.driver), "")
    return {place.driver, *_CATALOGUE.get(key, ())}


_CATALOGUE = {
    "speed": ("speed_rad_s",), "position": ("position_rad",), "acceleration": ("acceleration_rad_s2",),
    "input": ("current_A", "current_ref_A"),
}  # fmt: skip


def _signals(one: Series, output: FloatArray) -> dict[str, FloatArray]:
    width, speed = max(0.5, _SLOPE_S / one.step), output[SPEED]
    # The simulated motion: a noisy measured one would share its noise with the residual.
    found = {
        "speed": speed,
        "input": one.input,
        "acceleration": np.asarray(np.gradient(speed, one.time_s)),
        "time": one.time_s,
        "uneven": one.time_s,
        "slope": np.asarray(np.gradient(gaussian_filter1d(one.input, width), one.time_s)),
    }
    if one.angle.size:
        found["position"] = found["dry"] = one.angle
    return found


def _parts(key: str, signals: list[dict[str, FloatArray]], count: int) -> tuple[FloatArray, list[FloatArray]]:
    """Return the knots of a curve over a variable, and for each record the parts of the curve, shape (n, k)."""
    x = np.concatenate([one[key] for one in signals])
    if key == "slope":
        top = float(np.max(np.abs(x)))
        return np.array([top]), [one[key][:, None] / top for one in signals]
    if key == "uneven":
        return np.array([float(x.min()), float(x.max())]), _uneven(signals)
    if key != "time":
        knots = spread_knots(x, count)
        hats = [hat_basis(one[key], knots) for one in signals]
        if key == "dry":
            # A friction whose level depends on the place opposes the motion.
            hats = [-hat * np.sign(one["speed"])[:, None] for hat, one in zip(hats, signals, strict=True)]
        return knots, hats
    knots = np.linspace(float(x.min()), float(x.max()), _DRIFT_KNOTS)
    hats = [hat_basis(one[key], knots) for one in signals]
    return knots, [
        np.concatenate([hat * one["speed"][:, None], hat * one["input"][:, None]], axis=1)
        for hat, one in zip(hats, signals, strict=True)
    ]


def _uneven(signals: list[dict[str, FloatArray]]) -> list[FloatArray]:
    """Return torques whose drift is not in proportion to the input or the speed: what warms up may be bent itself."""
    top = {
        key: max(float(np.max(np.abs(one[key]))) for one in signals) + 1e-300 for key in ("input", "speed")
    }
    last = max(float(one["time"][-1] - one["time"][0]) for one in signals)
    return [
        np.stack([(one["time"] - one["time"][0]) / last * (one[key] / top[key]) ** 3 for key in top], axis=1)
        for one in signals
    ]


def _responses(
    one: Series, output: FloatArray, parts: FloatArray, at: tuple[Port, str, FloatArray]
) -> dict[int, FloatArray]:
    """Return how the parts (n, k) of a curve move the outputs, by row, each of shape (n, k)."""
    port, key, vector = at
    if port is Port.SENSOR:
        # An error of the angle sensor scales the speed by its slope; one of the speed sensor adds to it.
        return {SPEED: parts * output[SPEED][:, None] if key == "position" else parts}
    if port is Port.CURRENT and key == "input":
        return {CURRENT: parts}
    speed = _speed_response(one, output[SPEED], parts, vector)
    angle = np.zeros_like(speed)
    for a, b in one.edges:
        angle[a:b] = np.cumsum(speed[a:b], axis=0) * one.step
    return {SPEED: speed, POSITION: angle}


def _speed_response(one: Series, speed: FloatArray, torque: FloatArray, vector: FloatArray) -> FloatArray:
    """Return how torques (n, k) move the speed of the linear joint, shape (n, k); at rest they do not."""
    found = np.zeros_like(torque)
    rate = float(vector[s.VISCOUS] / vector[s.INERTIA])
    decay = float(np.exp(-rate * one.step))
    gain = one.step * 0.5 * (1.0 + decay) / float(vector[s.INERTIA])
    moving = torque * (speed != 0.0)[:, None]
    for a, b in one.edges:
        found[a:b] = lfilter([0.0, gain], [1.0, -decay], moving[a:b], axis=0)
    return found


def flat_columns(problem: SimulationProblem, responses: list[dict[int, FloatArray]]) -> FloatArray:
    """Weight and whiten responses as the residual was, shape (N, k)."""
    columns = []
    for k in range(next(iter(responses[0].values())).shape[1]):
        outputs = []
        for response, one in zip(responses, problem.series, strict=True):
            output = np.zeros((4, one.n))
            for row, values in response.items():
                output[row] = values[:, k]
            outputs.append(output)
        columns.append(problem.flatten(outputs))
    return np.stack(columns, axis=1)


def _shape(knots: FloatArray, columns: FloatArray, fit: Fit) -> tuple[tuple[float, float], ...]:
    # What the joint's own parameters could as well explain is not drawn: of all curves that fit, the flattest.
    joined = np.concatenate([columns, fit.jacobian], axis=1)
    scale = np.linalg.norm(joined, axis=0) + 1e-300
    heights = solve_by_rank(joined / scale, fit.residual, _SHAPE_RANK) / scale
    return tuple((float(x), float(y)) for x, y in zip(knots, heights[: knots.size], strict=True))
