"""A term without a name: the torque over one variable as a curve that is fitted in the simulation itself.

It closes what no law of the catalogue explains, so that a simulation can be used before the effect is understood. It is
no finding: the answer stays `unknown`.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discrepancy.effects.spec import Port, Ranges
from discrepancy.fitting.levenberg import fit
from discrepancy.fitting.parameters import FitParameter
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.locate import Place
from discrepancy.search.state import State
from discrepancy.simulation import slots as s

FloatArray = NDArray[np.float64]

OWNER = "spline"
_DRIVERS = {"speed": s.SPLINE_OVER_SPEED, "position": s.SPLINE_OVER_ANGLE, "input": s.SPLINE_OVER_CURRENT}
_ITERATIONS = 10


@dataclass(frozen=True, slots=True, kw_only=True)
class SplineTerm:
    """A fitted curve.

    Attributes:
        driver: column that it is a function of.
        points: (variable, torque on the joint), straight lines between them; beyond the ends the torque stays.
        vector: parameter vector of the simulation that has the curve in it.
    """

    driver: str
    points: tuple[tuple[float, float], ...]
    vector: FloatArray


def fit_spline(
    problem: SimulationProblem, state: State, ranges: Ranges, place: Place, names: Mapping[str, str]
) -> SplineTerm | None:
    """Fit a curve of the torque over the variable of `place` beside a model; None where no torque can stand for it."""
    key = next((key for key, column in names.items() if column == place.driver), "")
    if place.port is not Port.TORQUE or key not in _DRIVERS or not 2 < len(place.shape) <= s.SPLINE_KNOTS:
        return None
    vector = state.fit.vector.copy()
    vector[s.SPLINE_DRIVER], vector[s.SPLINE_COUNT] = _DRIVERS[key], len(place.shape)
    more = []
    # It begins flat: the linearised heights go with other values of the joint's own parameters.
    for i, (x, _) in enumerate(place.shape):
        vector[s.SPLINE_X + i], vector[s.SPLINE_Y + i] = x, 0.0
        more.append(
            FitParameter(
                owner=OWNER,
                name=f"y{i}",
                slot=s.SPLINE_Y + i,
                lower=-np.inf,
                upper=np.inf,
                scale=ranges.torque,
            )
        )
    fitted = fit(problem, [*state.fit.parameters, *more], vector, state.fit.starts, _ITERATIONS)
    if fitted.loss >= state.fit.loss:
        return None
    points = tuple(
        (float(fitted.vector[s.SPLINE_X + i]), float(fitted.vector[s.SPLINE_Y + i])) for i in range(len(more))
    )
    return SplineTerm(driver=place.driver, points=points, vector=fitted.vector)
