"""How well a chaotic motion determines a model: fits to stretches of the records, each alone.

The loss of a chaotic motion has many hollows, and which one a fit ends in is decided by single contacts. The curvature
of that hollow says nothing about the others, and more data do not average them out. So the same fit is made on every
stretch alone, from the common estimate, and how far these estimates lie from it is its error: not divided by the
root of their number, as independent estimates without a common bias would allow. They are few: what is returned is
larger by as much as Student's 95 % interval is wider than the normal one.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm, t

from discrepancy.data.series import Series, cut_windows
from discrepancy.fitting.levenberg import Fit, fit
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.halves import part_of

FloatArray = NDArray[np.float64]

_STRETCH_S = 5.0
_WINDOW_S = 1.0
"""Length in which a chaotic motion can be followed."""
_LEAST, _MOST = 4, 8
_ITERATIONS = 6
_TAIL = 0.975


def stretch_variances(problem: SimulationProblem, at: Fit) -> FloatArray:
    """Return the mean squared distance of the stretches' estimates from the common one, widened, SI units, shape (p,).

    Args:
        problem: the records.
        at: the common estimate.
    """
    duration = sum(one.n * one.step for one in problem.series)
    count = int(np.clip(round(duration / _STRETCH_S), _LEAST, _MOST))
    total = np.zeros(len(at.parameters))
    parts = [part for one in problem.series for part in _parts(one, max(1, count // len(problem.series)))]
    for part in parts:
        alone = replace(problem, series=(cut_windows(part, _WINDOW_S),))
        found = fit(alone, at.parameters, at.vector, alone.initial_starts(), _ITERATIONS)
        total += (found.values - at.values) ** 2
    wider = float(t.ppf(_TAIL, len(parts)) / norm.ppf(_TAIL))
    return total / len(parts) * wider**2


def _parts(one: Series, count: int) -> list[Series]:
    """Return a record in consecutive parts of equal length."""
    edges = np.linspace(0, one.n, count + 1).astype(int)
    return [part_of(one, int(a), int(b)) for a, b in zip(edges[:-1], edges[1:], strict=True)]
