"""Is something material left that no effect of the catalogue explains?"""

from collections.abc import Mapping

import numpy as np

from discrepancy.effects.spec import Port
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.locate import Place, locate
from discrepancy.search.greedy import Context
from discrepancy.search.noise import residual_parts
from discrepancy.search.state import State

LEFT_NOISE = 0.15
"""Least remainder, in units of one sample's noise, that is called unknown."""
LEFT_GAP = 0.2
"""Least remainder in parts of the gap that the search began with."""
LEFT_GAP_CHAOTIC = 0.4
"""The same with backlash in the model, whose free run is chaotic."""
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
    size = problem.counted * context.bin_size
    start = np.sqrt(max(0.0, first.fit.loss - problem.rows) / size)
    left = np.sqrt(max(0.0, _white_loss(problem, last) - problem.rows) / size)
    part = LEFT_GAP_CHAOTIC if "backlash" in last.present else LEFT_GAP
    if left < max(LEFT_NOISE, part * start):
        return None
    places = locate(problem.series, residual_parts(problem, last), last.fit.vector, names)
    if not places:
        return Place(port=Port.TORQUE, driver="time_s", region=None, share=0.0)
    best = places[0]
    if context.repeat_noise is None and best.share < LEFT_SHARE:
        return None
    return best


def _white_loss(problem: SimulationProblem, state: State) -> float:
    residual = problem.measured() - problem.flatten(problem.simulate(state.fit.vector, state.fit.starts))
    return float(residual @ residual)
