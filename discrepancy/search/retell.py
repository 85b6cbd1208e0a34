"""Tell the accepted models again where later rounds have changed what earlier ones said."""

from collections.abc import Sequence
from dataclasses import replace

from discrepancy.effects.spec import Ranges
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.context import Context
from discrepancy.search.greedy import closed_amount
from discrepancy.search.outcome import Step
from discrepancy.search.state import refit, without

AGAIN = 8


def retold(
    problem: SimulationProblem, steps: Sequence[Step], ranges: Ranges, context: Context
) -> tuple[Step, ...]:
    """Return the steps with models that hold the effects named so far and no others, and what each closes then.

    A law that was dropped, simplified or exchanged still stands in the models of the steps between, and what these
    closed was measured beside it. Each such model is fitted again from the last one, without the later effects.

    Args:
        problem: with white noise weights.
        steps: accepted models, base first; the last one's is the whole model.
        ranges: sizes of the signals.
        context: noise of one sample.
    """
    told, last = [steps[0]], steps[-1].state
    for k, step in enumerate(steps[1:], start=1):
        names = {one.added for one in steps[1 : k + 1]}
        state = step.state
        if set(state.added) != names:
            later = [name for name in last.added if name not in names]
            state = refit(problem, without(last, later), ranges, AGAIN)
        if state is not step.state or told[-1].state is not steps[k - 1].state:
            closed = closed_amount(problem, context, (told[-1].state, state))
            step = replace(step, state=state, closed=closed)
        told.append(step)
    return tuple(told)
