"""Is something material left that no effect of the catalogue explains?"""

from collections.abc import Mapping

from discrepancy.effects.spec import Port
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.locate import Place, locate
from discrepancy.search.context import Context
from discrepancy.search.noise import residual_parts
from discrepancy.search.state import State

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
    start = context.rms(problem, first.fit.loss - problem.rows)
    left = context.rms(problem, _white_loss(problem, last) - problem.rows)
    if left < max(LEFT_NOISE, LEFT_GAP * start):
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
