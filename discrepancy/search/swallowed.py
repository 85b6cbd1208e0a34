"""A constant torque that a named weight may have taken in: declared where the records cannot tell.

Over a short travel the sum of a sinusoid and a constant is a sinusoid of a longer wave, but for terms of third order.
A search that found the weight first then needs no constant, and the wave number is what went wrong. How far the values
of such models lie from the named one's is part of its standard errors.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from discrepancy.effects.spec import Ranges
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.levenberg import fit
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.choice import Contender
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
    if WEIGHT not in last.added or set(OFFSETS) & set(last.present) or last.is_chaotic:
        return tuple(steps)
    rivals = _with_constant(problem, last, ranges, limits)
    if not rivals:
        return tuple(steps)
    more: dict[str | None, list[Equivalent]] = {
        WEIGHT: [(WEIGHT, one) for one in OFFSETS],
        LEVEL: [ASYMMETRIC],
    }
    told = [
        replace(step, equivalents=tuple(dict.fromkeys([*step.equivalents, *more.get(step.added, [])])))
        for step in steps
    ]
    far = np.max([np.abs(one.fit.vector - last.fit.vector) for one in rivals], axis=0)
    apart = {p.slot: float(far[p.slot]) for p in last.fit.parameters}
    return (*told[:-1], replace(told[-1], apart=apart, rivals=_pair(problem, last, rivals[0])))


def _pair(problem: SimulationProblem, named: State, rival: State) -> tuple[Contender, ...]:
    """Return the named model and the one with a constant as what an experiment has to tell apart."""
    unit = max(1.0, named.fit.loss / problem.rows)
    fall = (named.fit.loss - rival.fit.loss) / unit
    return (
        Contender(name=WEIGHT, state=named, white_loss=named.fit.loss),
        Contender(name=f"{WEIGHT} + {OFFSETS[0]}", state=rival, white_loss=rival.fit.loss, fall=fall),
    )


def _with_constant(
    problem: SimulationProblem, state: State, ranges: Ranges, limits: tuple[SearchOptions, Context]
) -> list[State]:
    """Return the models with a shorter wave and a material constant beside it that fit as well as the fitted wave.

    The nearest wave, which is the hardest to tell from the fitted one, comes first.
    """
    options, context = limits
    wave, offset = EFFECTS[WEIGHT].wave, OFFSETS[0]
    if wave is None:
        return []
    found = []
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
            found.append(trial)
    return found
