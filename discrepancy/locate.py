"""Where simulation and measurement part: which variable explains the residual, in which region, with what share.

The speed residual of the simulation is turned into the torque (or input) that would explain it; that torque, and the
residual
itself, are described by a spline of one variable at a time. The share is what the spline predicts on blocks it was not
fitted to, relative to the part of the residual that is not noise.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from discrepancy.data.ranges import measured_speed, missing_torque
from discrepancy.data.series import CURRENT, POSITION, SPEED, TORQUE, Series
from discrepancy.effects.spec import Port

FloatArray = NDArray[np.float64]

KNOTS = 14
_BLOCKS = 12


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """One place of disagreement.

    Attributes:
        driver: column name, `acceleration_rad_s2`, `time_s` or `frequency`.
        region: where 80 % of the explained energy lies, in the driver's unit; None if it is everywhere.
        share: part of the excess error that a curve over the driver predicts, 0 to 1.
        shape: the curve, (x, y) pairs.
    """

    port: Port
    driver: str
    region: tuple[float, float] | None
    share: float
    shape: tuple[tuple[float, float], ...] = ()

    def to_dict(self) -> dict[str, object]:
        """Return the entry of `where` in `gap.json`."""
        return {
            "port": self.port.value,
            "driver": self.driver,
            "region": None if self.region is None else list(self.region),
            "share": round(self.share, 4),
        }


def hat_basis(x: FloatArray, knots: FloatArray) -> FloatArray:
    """Return piecewise-linear hat functions over `knots` at `x`, shape (n, len(knots))."""
    place = np.clip(np.searchsorted(knots, x) - 1, 0, knots.size - 2)
    part = np.clip((x - knots[place]) / (knots[place + 1] - knots[place]), 0.0, 1.0)
    basis = np.zeros((x.size, knots.size))
    rows = np.arange(x.size)
    basis[rows, place] = 1.0 - part
    basis[rows, place + 1] = part
    return basis


def spread_knots(x: FloatArray, count: int = KNOTS) -> FloatArray:
    """Return knots at quantiles of `x`, distinct; for a signed variable two of them stand close to zero."""
    knots = np.quantile(x, np.linspace(0.0, 1.0, count))
    if x.min() < 0.0 < x.max():
        near = 0.01 * float(np.std(x))
        knots = np.concatenate([knots[np.abs(knots) > near], [-near, near]])
    knots = np.unique(knots)
    return knots if knots.size > 2 else np.linspace(x.min(), x.min() + max(np.ptp(x), 1e-9), 3)


def predicted_share(basis: FloatArray, target: FloatArray) -> tuple[float, FloatArray]:
    """Return the part of the variance of `target` that `basis` predicts on held-out blocks, and the coefficients."""
    n = target.size
    edges = np.linspace(0, n, _BLOCKS + 1).astype(int)
    normal, right = basis.T @ basis, basis.T @ target
    ridge = 1e-6 * np.trace(normal) / basis.shape[1] * np.eye(basis.shape[1])
    lost = 0.0
    for a, b in zip(edges[:-1], edges[1:], strict=True):
        part = basis[a:b]
        c = np.linalg.solve(normal - part.T @ part + ridge, right - part.T @ target[a:b])
        lost += float(np.sum((target[a:b] - part @ c) ** 2))
    total = float(np.sum((target - target.mean()) ** 2)) + n * float(target.mean()) ** 2
    coefficients = np.linalg.solve(normal + ridge, right)
    return max(0.0, 1.0 - lost / max(total, 1e-300)), coefficients


def locate(
    series: Sequence[Series],
    residuals: Sequence[Sequence[FloatArray]],
    vector: FloatArray,
    names: Mapping[str, str],
) -> list[Place]:
    """Return the places of disagreement, largest share first.

    Args:
        series: the (binned) training records.
        residuals: measured minus simulated, [record][channel].
        vector: parameters of the simulation that left them.
        names: column names of `speed`, `position`, `input`.
    """
    rows = [channel.row for channel in series[0].channels]
    main = next((row for row in (TORQUE, SPEED, POSITION) if row in rows), None)
    if main is None or not series[0].angle.size:
        return []
    c = rows.index(main)
    gathered: dict[str, list[FloatArray]] = {}
    for one, record in zip(series, residuals, strict=True):
        error = record[c] if main != POSITION else np.gradient(record[c], one.time_s)
        for key, values in _signals(one, error, vector).items():
            gathered.setdefault(key, []).append(values)
    joined = {key: np.concatenate(parts) for key, parts in gathered.items()}
    places = [
        _place(joined, driver, Port.TORQUE, "torque", names)
        for driver in ("speed", "position", "input", "acceleration")
        if driver in joined
    ]
    places.append(_drift(joined, names))
    places.append(_rate(joined, names))
    if main != TORQUE:
        places.append(_place(joined, "speed", Port.SENSOR, "residual", names))
    if CURRENT in rows:
        k = rows.index(CURRENT)
        joined["current_residual"] = np.concatenate([record[k] for record in residuals])
        places.insert(0, _place(joined, "input", Port.CURRENT, "current_residual", names))
    return sorted(places, key=lambda place: -place.share)


def _signals(one: Series, residual: FloatArray, vector: FloatArray) -> dict[str, FloatArray]:
    speed = measured_speed(one)
    smooth = gaussian_filter1d(speed, max(0.5, 0.01 / one.step))
    found = {
        "torque": missing_torque(one, residual, vector) if one.channels[0].row != TORQUE else -residual,
        "residual": gaussian_filter1d(residual, max(0.5, 0.01 / one.step)),
        "speed": smooth,
        "input": one.input,
        "acceleration": np.asarray(np.gradient(smooth, one.time_s)),
        "time": one.time_s,
        "slope": np.asarray(np.gradient(gaussian_filter1d(one.input, max(0.5, 0.01 / one.step)), one.time_s)),
    }
    if one.angle.size:
        found["position"] = one.angle
    return found


def _place(
    joined: Mapping[str, FloatArray], driver: str, port: Port, target: str, names: Mapping[str, str]
) -> Place:
    x, y = joined[driver], joined[target]
    knots = spread_knots(x)
    basis = hat_basis(x, knots)
    share, coefficients = predicted_share(basis, y)
    curve = basis @ coefficients
    return Place(
        port=port, driver=names.get(driver, driver), region=region_of(x, curve**2), share=share,
        shape=tuple((float(a), float(b)) for a, b in zip(knots, coefficients, strict=True)),
    )  # fmt: skip


def _drift(joined: Mapping[str, FloatArray], names: Mapping[str, str]) -> Place:
    """Return what a slowly changing multiple of speed and input explains."""
    knots = np.linspace(float(joined["time"].min()), float(joined["time"].max()), 5)
    hats = hat_basis(joined["time"], knots)
    fixed = np.stack([joined["speed"], joined["input"]], axis=1)
    basis = np.concatenate([hats * joined["speed"][:, None], hats * joined["input"][:, None]], axis=1)
    steady, _ = predicted_share(fixed, joined["torque"])
    share, coefficients = predicted_share(basis, joined["torque"])
    shape = tuple((float(a), float(b)) for a, b in zip(knots, coefficients[: knots.size], strict=True))
    return Place(port=Port.TORQUE, driver="time_s", region=None, share=max(0.0, share - steady), shape=shape)


def _rate(joined: Mapping[str, FloatArray], names: Mapping[str, str]) -> Place:
    """Return what the slope of the input explains: a delay or a lag."""
    share, coefficients = predicted_share(joined["slope"][:, None], joined["torque"])
    top = float(np.max(np.abs(joined["slope"])))
    return Place(
        port=Port.CURRENT, driver="frequency", region=None, share=share,
        shape=((-top, -top * float(coefficients[0])), (top, top * float(coefficients[0]))),
    )  # fmt: skip


def region_of(x: FloatArray, energy: FloatArray) -> tuple[float, float] | None:
    """Return the interval of `x` that holds the middle 80 % of an energy, shape (n,); None if it is zero."""
    order = np.argsort(x)
    total = np.cumsum(energy[order])
    if total[-1] <= 0.0:
        return None
    low, high = np.searchsorted(total, [0.1 * total[-1], 0.9 * total[-1]])
    return float(x[order[low]]), float(x[order[min(high, x.size - 1)]])
