"""Sizes of the signals, and the wave numbers at which a residual repeats over the angle: where fits start."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

from discrepancy.data.series import POSITION, SPEED, TORQUE, Series
from discrepancy.effects.spec import Ranges
from discrepancy.simulation import slots as s

FloatArray = NDArray[np.float64]

_SMOOTH_S = 0.01


def measured_speed(series: Series) -> FloatArray:
    """Return the measured speed, or the smoothed slope of the measured angle, shape (n,)."""
    for channel in series.channels:
        if channel.row == SPEED:
            return channel.values
    width = max(1.0, 0.02 / series.step)
    return np.asarray(np.gradient(gaussian_filter1d(series.angle, width), series.time_s))


def signal_ranges(series: Sequence[Series], vector: FloatArray) -> Ranges:
    """Measure the sizes of the signals in the (binned) training records."""
    current = np.concatenate([one.input for one in series])
    speed = np.concatenate([np.abs(measured_speed(one)) for one in series])
    angle = np.concatenate([one.angle for one in series if one.angle.size] or [np.array([-1.0, 1.0])])
    return Ranges(
        torque=max(1e-12, float(vector[s.TORQUE_CONSTANT] * np.std(current))),
        speed=max(1e-12, float(np.quantile(speed, 0.995))),
        current=max(1e-12, float(np.max(np.abs(current)))),
        duration=max(float(one.time_s[-1]) for one in series),
        step=series[0].original_step,
        low=float(angle.min()),
        high=float(max(angle.max(), angle.min() + 1e-6)),
        inertia=float(vector[s.INERTIA]),
        rate=float(vector[s.VISCOUS] / vector[s.INERTIA]),
    )


def missing_torque(series: Series, residual: FloatArray, vector: FloatArray) -> FloatArray:
    """Return the torque that would explain a speed residual of the linear joint: J dr/dt + B r, smoothed."""
    smooth = gaussian_filter1d(residual, max(0.5, _SMOOTH_S / series.step))
    return np.asarray(vector[s.INERTIA] * np.gradient(smooth, series.time_s) + vector[s.VISCOUS] * smooth)


def find_waves(
    series: Sequence[Series], residuals: Sequence[FloatArray], vector: FloatArray
) -> dict[str, tuple[float, ...]]:
    """Return wave numbers, 1/rad, at which the missing torque (or speed) repeats over the angle.

    The residual is compared with what the linear joint would make of a torque that repeats (a matched filter), not
    turned into a torque first: that would raise its noise with the frequency, and hide slow waves behind fast ones.

    Args:
        series: the (binned) training records.
        residuals: residual of each record's first output, shape (n,).
        vector: kernel parameters of the fitted joint.
    """
    usable = [
        (one, r)
        for one, r in zip(series, residuals, strict=True)
        if one.angle.size and np.ptp(one.angle) > 1e-6
    ]
    if not usable:
        return {}
    travel = max(float(np.ptp(one.angle)) for one, _ in usable)
    waves = _wave_axis(
        travel, max(float(np.max(np.abs(measured_speed(one)))) * one.step for one, _ in usable)
    )
    matched = {name: np.zeros(waves.size) for name in ("torque", "current", "acceleration", "speed")}
    expected = {name: np.zeros(waves.size) for name in matched}
    for one, residual in usable:
        speed = measured_speed(one)
        slope = np.gradient(gaussian_filter1d(speed, max(0.5, _SMOOTH_S / one.step)), one.time_s)
        joint = None if one.channels[0].row == TORQUE else vector
        if one.channels[0].row == POSITION:
            residual = np.gradient(gaussian_filter1d(residual, max(0.5, _SMOOTH_S / one.step)), one.time_s)
        left = _unexplained(one, residual, speed, joint)
        back = left if joint is None else _answer(left[::-1], one.step, joint)[::-1]
        for name, factor, signal, through in (
            ("torque", np.ones_like(speed), back, joint),
            ("current", one.input, back, joint),
            ("acceleration", slope, back, joint),
            ("speed", speed, left, None),
        ):
            product = signal * factor
            matched[name] += _transform(one.angle, product - product.mean(), waves.size, travel)
            expected[name] += _expected(factor, speed, waves, through)
    power = {name: matched[name] / expected[name] for name in matched}
    low, high = waves <= 1.2, waves >= 0.8
    return {
        "torque_low": _peaks(waves, power["torque"], low, 2),
        "torque_high": _peaks(waves, power["torque"], high, 4),
        "current": _peaks(waves, power["current"], high, 2),
        "acceleration": _peaks(waves, power["acceleration"], waves > 0.05, 2),
        "speed": _peaks(waves, power["speed"], waves > 0.0, 3),
    }


def _answer(torque: FloatArray, step: float, vector: FloatArray) -> FloatArray:
    """Return the speed that the linear joint makes of a torque held over each sample, shape (n,)."""
    rate = max(0.0, float(vector[s.VISCOUS])) / float(vector[s.INERTIA])
    keep = math.exp(-rate * step)
    gain = (1.0 - keep) / (rate * vector[s.INERTIA]) if rate * step > 1e-9 else step / vector[s.INERTIA]
    return np.asarray(lfilter([gain], [1.0, -keep], torque))


def _unexplained(
    series: Series, residual: FloatArray, speed: FloatArray, joint: FloatArray | None
) -> FloatArray:
    """Return the residual without what an offset, viscous and dry friction and the motor's torque explain."""
    regressors = np.stack([np.ones_like(speed), speed, np.sign(speed), series.input])
    if joint is not None:
        regressors = np.stack([_answer(one, series.step, joint) for one in regressors])
    return np.asarray(residual - regressors.T @ np.linalg.lstsq(regressors.T, residual, rcond=None)[0])


def _expected(
    factor: FloatArray, speed: FloatArray, waves: FloatArray, joint: FloatArray | None
) -> FloatArray:
    """Return the power that a wave of unit amplitude times `factor` leaves in the residual, by wave number.

    While the speed hardly changes, a wave over the angle is one over time at k w, which the joint passes with
    1 / (B^2 + J^2 k^2 w^2). The speeds are counted in classes, weighted with the factor's square.
    """
    if joint is None:
        return np.full(waves.size, float(factor @ factor) + 1e-300)
    weight, edges = np.histogram(np.abs(speed), bins=64, weights=factor**2)
    middle = 0.5 * (edges[1:] + edges[:-1])
    frequency = np.outer(waves, middle)
    return np.asarray((1.0 / (joint[s.VISCOUS] ** 2 + (joint[s.INERTIA] * frequency) ** 2)) @ weight + 1e-300)


def _wave_axis(travel: float, step: float) -> FloatArray:
    """Return wave numbers up to what the sampling resolves, at most 100 per rad."""
    top = min(100.0, 0.5 * math.pi / max(step, 1e-9))
    spacing = math.pi / travel
    return spacing * np.arange(1, max(4, min(200_000, int(top / spacing))), dtype=np.float64)


def _transform(angle: FloatArray, values: FloatArray, count: int, travel: float) -> FloatArray:
    """Return the power of `values` over wave numbers: a Fourier transform over the angle by counting into cells."""
    cells = max(64, 8 * count)
    place = ((angle - angle.min()) / (2.0 * travel) * cells).astype(np.int64) % cells
    power = np.abs(np.fft.rfft(np.bincount(place, weights=values, minlength=cells))) ** 2
    return np.asarray(power[1 : count + 1])


def _peaks(waves: FloatArray, power: FloatArray, where: NDArray[np.bool_], count: int) -> tuple[float, ...]:
    """Return the wave numbers of the strongest local maxima."""
    inside = np.where(where, power, -1.0)
    padded = np.concatenate([[-1.0], inside, [-1.0]])
    local = (inside > 0.0) & (inside >= padded[:-2]) & (inside >= padded[2:])
    order = np.flatnonzero(local)
    order = order[np.argsort(inside[order])[::-1]][:count]
    return tuple(float(waves[i]) for i in order)
