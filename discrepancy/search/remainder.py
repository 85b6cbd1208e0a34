"""Is something material left that no effect of the catalogue explains?"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from discrepancy.effects.spec import Port
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.locate import Place, locate
from discrepancy.search.context import Context
from discrepancy.search.noise import residual_parts
from discrepancy.search.outputs import output_losses, output_rows
from discrepancy.search.state import State

FloatArray = NDArray[np.float64]

LEFT_NOISE = 0.15
"""Least remainder, in units of one sample's noise, that is called unknown."""
LEFT_GAP = 0.2
"""Least remainder in parts of the gap that the search began with."""
LEFT_SHARE = 0.03
"""Least part of the remaining torque residual that a curve over one variable predicts on held-out blocks."""


def find_remainder(
    problem: SimulationProblem, first: State, last: State, context: Context, names: Mapping[str, str]
) -> Place | None:
    """Return where the material remainder of the last model lies, or None if there is none.

    Args:
        problem: with white noise weights.
        first: the recalibrated base model.
        last: the final model.
        context: bin size and noise of repeats.
        names: column names of the drivers.
    """
    rows = output_rows(problem)
    start = context.rms(problem, output_losses(problem, first.fit.residual) - rows)
    left = context.rms(problem, _white_losses(problem, last) - rows)
    if np.all(left < np.maximum(LEFT_NOISE, LEFT_GAP * start)):
        return None
    places = locate(problem.series, residual_parts(problem, last), last.fit.vector, names)
    if not places:
        return Place(port=Port.TORQUE, driver="time_s", region=None, share=0.0)
    best = places[0]
    if context.repeat_noise is None and best.share < LEFT_SHARE:
        return None
    return best


def _white_losses(problem: SimulationProblem, state: State) -> FloatArray:
    residual = problem.measured() - problem.flatten(problem.simulate(state.fit.vector, state.fit.starts))
    return output_losses(problem, residual)
