"""Two effects at once, where no single one helps although much is left.

Some effects hide each other: a joint that hangs on a spring and sticks follows neither law alone. The few best single
effects become bases; on top of each a round is run as always. A pair must earn more than a single effect does: the
false-alarm limit of a search over so many more models, and nearly all of the gap.
"""

from dataclasses import replace

import numpy as np

from discrepancy.effects.spec import Ranges
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.choice import Contender
from discrepancy.search.context import Context
from discrepancy.search.greedy import Round, closed_amount, run_round
from discrepancy.search.judge import held_out
from discrepancy.search.options import SearchOptions
from discrepancy.search.outputs import output_losses, output_rows
from discrepancy.search.state import State, refit

BASES = 3
"""How many single effects are tried as the first of a pair."""
PAIR_ALARM = 8.0
"""Further fall of the held-out loss: a pair is one of some sixty models (2 log 60)."""
PAIR_PART = 0.95
"""Least part of the remaining gap (rms) that a pair closes: two laws of the wrong form close most of anything."""


def find_pair(
    problem: SimulationProblem,
    state: State,
    rest: tuple[Ranges, SearchOptions, Context],
    failed: Round,
) -> tuple[Round, ...]:
    """Return the rounds that add the first and the second effect of the best pair, or nothing.

    Args:
        problem: with white noise weights.
        state: the model on which no single effect was accepted.
        rest: sizes of the signals, limits, and the search's context.
        failed: that round, whose contenders are the bases.
    """
    ranges, options, context = rest
    left = context.rms(problem, output_losses(problem, state.fit.residual) - output_rows(problem))
    if state.added or np.all(left <= np.maximum(options.left_noise, options.left_signal * context.signal)):
        return ()
    relaxed = replace(options, first_part=0.0, later_part=0.0)
    found = []
    for base in sorted(failed.contenders, key=lambda c: c.white_loss)[:BASES]:
        # The base's own fit is a start only; its loss under the search's weights is what the second is judged beside.
        start = refit(problem, base.state, ranges, 3)
        done = run_round(problem, start, ranges, relaxed, replace(context, closed=base.closed))
        second = done.winner
        if second is not None and _earned(problem, state, (done, second), rest):
            first = replace(failed, winner=replace(base, state=start), equivalents=())
            found.append((second.white_loss, (first, done)))
    return min(found, key=lambda one: one[0])[1] if found else ()


def _earned(
    problem: SimulationProblem,
    state: State,
    second: tuple[Round, Contender],
    rest: tuple[Ranges, SearchOptions, Context],
) -> bool:
    """Judge both effects together against the model without either."""
    ranges, options, context = rest
    done, both = second
    sharp = done.problem
    without = refit(sharp, state, ranges, 3)
    pair = refit(sharp, both.state, ranges, 3)
    unit = pair.fit.loss / sharp.rows
    unit = max(1.0, unit) if context.repeat_noise is not None else unit
    fall = (held_out(sharp, without.fit).loss - held_out(sharp, pair.fit).loss) / unit
    losses = output_losses(problem, state.fit.residual)
    # The contender's fit has the weights of the round; beside the first model it needs those of the search.
    closed = closed_amount(problem, context, (state, refit(problem, both.state, ranges, 3)))
    left = context.rms(problem, losses - output_rows(problem))
    return (
        fall > context.alarm(options) + PAIR_ALARM + options.per_parameter * (pair.size - state.size)
        and bool(np.any(closed > np.maximum(context.material(options, state.present), PAIR_PART * left)))
        and both.white_loss < (1.0 - options.material_rms) ** 2 * state.fit.loss
    )
