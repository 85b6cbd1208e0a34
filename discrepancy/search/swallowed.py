"""A constant torque that a named weight may have taken in: declared where the records cannot tell.

Over a short travel the sum of a sinusoid and a constant is a sinusoid of a longer wave, but for terms of third order.
A search that found the weight first then needs no constant, and the wave number is what went wrong.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from discrepancy.effects.spec import Ranges
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.levenberg import fit
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.context import Context
from discrepancy.search.greedy import closed_amount
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import Step
from discrepancy.search.same import ASYMMETRIC, Equivalent
from discrepancy.search.state import State, parameters_of, without

WEIGHT, OFFSETS = "gravity_unbalance", ("load_torque_offset", "current_sensor_offset")
LEVEL = "coulomb_friction"
_SHORTER = (1.25, 1.5, 2.0, 3.0, 4.0)
"""Multiples of the fitted wave number at which the weight is tried again, with a constant beside it."""
_STEPS = 4


def with_swallowed_offset(
    problem: SimulationProblem, steps: Sequence[Step], ranges: Ranges, limits: tuple[SearchOptions, Context]
) -> tuple[Step, ...]:
    """Return the steps with a weight and a constant declared equivalent to the weight, where both do as well.

    Args:
        problem: with white noise weights.
        steps: accepted models, base first; the last one's is the whole model.
        ranges: sizes of the signals.
        limits: options and the search's context.
    """
    last = steps[-1].state
    named = WEIGHT in last.added and not set(OFFSETS) & set(last.present)
    if not named or last.is_chaotic or not _may_hold(problem, last, ranges, limits):
        return tuple(steps)
    more: dict[str | None, list[Equivalent]] = {
        WEIGHT: [(WEIGHT, one) for one in OFFSETS],
        LEVEL: [ASYMMETRIC],
    }
    return tuple(
        replace(step, equivalents=tuple(dict.fromkeys([*step.equivalents, *more.get(step.added, [])])))
        for step in steps
    )


def _may_hold(
    problem: SimulationProblem, state: State, ranges: Ranges, limits: tuple[SearchOptions, Context]
) -> bool:
    """Return whether a shorter wave with a material constant beside it fits as well as the fitted wave."""
    options, context = limits
    wave, offset = EFFECTS[WEIGHT].wave, OFFSETS[0]
    if wave is None:
        return False
    unit = max(1.0, state.fit.loss / problem.rows)
    limit = state.fit.loss + options.doubt * unit
    both = (*state.added, offset)
    parameters = [p for p in parameters_of(state.base, state.given, both, ranges) if p.slot != wave.slot]
    for factor in _SHORTER:
        vector = state.fit.vector.copy()
        vector[wave.slot] *= factor
        if vector[wave.slot] > wave.upper:
            continue
        trial = replace(state, added=both, fit=fit(problem, parameters, vector, state.fit.starts, _STEPS))
        if trial.fit.loss > limit:
            continue
        bare = without(trial, [offset])
        bare = replace(bare, fit=fit(problem, [], bare.fit.vector, bare.fit.starts, 0))
        shown = closed_amount(problem, context, (bare, trial))
        if np.any(shown > context.material(options, state.added)):
            return True
    return False
