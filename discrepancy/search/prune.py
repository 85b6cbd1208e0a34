"""Drop what newer effects have made unnecessary, and replace laws by simpler ones that do as well."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from discrepancy.effects.spec import Ranges
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.context import Context
from discrepancy.search.greedy import closed_amount
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import Step
from discrepancy.search.same import exact_equivalents, simpler_laws
from discrepancy.search.state import State, polish, refit, scan_effect, without

FloatArray = NDArray[np.float64]


def prune(
    problem: SimulationProblem,
    found: tuple[State, list[Step]],
    ranges: Ranges,
    limits: tuple[SearchOptions, Context, FloatArray],
) -> tuple[State, list[Step]]:
    """Drop earlier effects that the newest one has made unnecessary, and replace laws by simpler ones that do as well.

    Args:
        problem: with white noise weights.
        found: the model so far and its steps.
        ranges: sizes of the signals.
        limits: options, bin size, and what has been closed so far.
    """
    current, steps = found
    options, context, closed = limits
    visible = replace(context, closed=closed).material(options, ())
    for name in current.added[:-1]:
        trial = refit(problem, without(current, [name]), ranges, 8)
        lost = closed_amount(problem, context, (trial, current))
        if np.all(lost < visible):
            current = trial
            steps = [step for step in steps if step.added != name]
            steps[-1] = replace(steps[-1], state=trial)
    for name in current.added:
        for simple in simpler_laws(name, current.added):
            if simple in current.added:
                continue
            trial = _simplified(problem, current, (name, simple), ranges)
            lost = closed_amount(problem, context, (trial, current))
            if np.all(lost < visible):
                current = trial
                same = tuple(exact_equivalents([*(one for one in trial.added if one != simple), simple]))
                steps = [
                    replace(st, added=simple, equivalents=same) if st.added == name else st for st in steps
                ]
                steps[-1] = replace(steps[-1], state=trial)
                break
    return current, steps


def _simplified(problem: SimulationProblem, state: State, pair: tuple[str, str], ranges: Ranges) -> State:
    """Return the model with a law replaced by a simpler one that it contains."""
    name, simple = pair
    place = state.added.index(name)
    found = polish(problem, scan_effect(problem, without(state, [name]), simple, ranges), ranges)
    return replace(found, added=(*state.added[:place], simple, *state.added[place + 1 :]))
