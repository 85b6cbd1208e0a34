"""How well does a model fitted to one half of the records predict the other half in a free run?"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from discrepancy.data.series import Series, with_starts
from discrepancy.fitting.free_run import best_free_run
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.state import State


def halves_error(problem: SimulationProblem, state: State, whole: Sequence[Series]) -> float:
    """Return the rms error of free runs over halves of the records, parameters fitted to the other halves.

    Args:
        problem: its noise weights are the error's unit.
        state: the model and where its fit begins.
        whole: the records, cut at holes only.

    Returns:
        The error; infinite where a free run runs away.
    """
    halves = [split_series(one) for one in whole]
    first, second = (replace(problem, series=tuple(pair[i] for pair in halves)) for i in (0, 1))
    loss = 0.0
    for fitted, judged in ((first, second), (second, first)):
        vector = best_free_run(fitted, state.fit.parameters, state.fit.vector).vector
        loss += best_free_run(judged, (), vector).loss
    return float(np.sqrt(loss / (first.rows + second.rows))) if np.isfinite(loss) else np.inf


def split_series(one: Series) -> tuple[Series, Series]:
    """Cut a record in two at its middle sample."""
    middle = one.n // 2
    return part_of(one, 0, middle), part_of(one, middle, one.n)


def part_of(one: Series, begin: int, end: int) -> Series:
    """Return some rows of a record with starting states of their own."""
    rows = slice(begin, end)
    channels = tuple(replace(c, values=c.values[rows], weight=c.weight[rows]) for c in one.channels)
    firsts = [max(a, begin) - begin for a, b in one.edges if a < end and b > begin]
    part = replace(
        one, time_s=one.time_s[rows], input=one.input[rows], angle=one.angle[rows], channels=channels,
        windows=np.array([-k - 1 for k in firsts], dtype=np.int64),
    )  # fmt: skip
    return with_starts(part)
