"""What a search has found: the accepted models in order, and every round as it went."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.series import TORQUE
from discrepancy.effects.spec import Port, Ranges
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.locate import Place, locate
from discrepancy.search.bench import Bench, make_bench
from discrepancy.search.choice import Contender
from discrepancy.search.context import Context
from discrepancy.search.curves import judge_curves
from discrepancy.search.greedy import Round
from discrepancy.search.noise import residual_parts
from discrepancy.search.options import SearchOptions
from discrepancy.search.same import Equivalent
from discrepancy.search.state import State

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """One accepted model, base first.

    Attributes:
        errors: standard errors of the fitted values, shape (p,), where another fit than the search's gave these.
        apart: how far the values of a model that is declared equivalent lie, by slot, where that was looked at.
        rivals: the whole model and one of several effects that is declared equivalent to it, where that was looked at.
    """

    state: State
    added: str | None
    equivalents: tuple[Equivalent, ...] = ()
    fall: float = 0.0
    closed: FloatArray = field(default_factory=lambda: np.zeros(1))
    errors: FloatArray | None = None
    apart: Mapping[int, float] = field(default_factory=dict)
    rivals: tuple[Contender, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchOutcome:
    """The accepted models in order and every round as it went.

    Attributes:
        at_ends: whether the first and last moments of the records, where a smoothed speed is wrong, made it what it is.
    """

    steps: tuple[Step, ...]
    rounds: tuple[Round, ...]
    problem: SimulationProblem
    ranges: Ranges
    context: Context
    names: Mapping[str, str]
    unknown: Place | None = None
    notes: tuple[str, ...] = field(default=())
    at_ends: bool = False

    @property
    def is_torque(self) -> bool:
        """Whether the torque balance was judged, not a simulation."""
        return self.problem.series[0].channels[0].row == TORQUE

    def bench(self, state: State) -> Bench | None:
        """Return a model of this search fitted under both noise models; None where torque is judged."""
        return None if self.is_torque else make_bench(self.problem, state, self.ranges, self.context)

    def places(self, state: State, bench: Bench | None) -> list[Place]:
        """Return where a model of this search fails on the training records, each port and driver once.

        Of several kinds of curve over one variable the one that closes most stands for it.

        Args:
            state: the model.
            bench: the same from `bench`.
        """
        if bench is None:
            return locate(
                self.problem.series, residual_parts(self.problem, state), state.fit.vector, self.names
            )
        least = SearchOptions().alarm
        found: dict[tuple[Port, str], Place] = {}
        for curve in judge_curves(bench, self.names):
            place = curve.place if curve.judged.fall > least else replace(curve.place, share=0.0)
            key = place.port, place.driver
            if key not in found or place.share > found[key].share:
                found[key] = place
        return list(found.values())

    @property
    def verdict(self) -> str:
        """`named`, `none` or `unknown`."""
        if self.unknown is not None:
            return "unknown"
        return "named" if len(self.steps) > 1 else "none"
