"""What a round of the search needs besides data and model, and the limits that follow from it."""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from discrepancy.data.repeats import Pair
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.problem import Noise, SimulationProblem
from discrepancy.search.options import SearchOptions


@dataclass(frozen=True, slots=True, kw_only=True)
class Context:
    """What a round needs besides data and model.

    Attributes:
        repeat_noise: noise model that repeats show, None without repeats.
        bin_size: variance of one sample over that of a bin (the number of samples in it for white noise).
        excluded: effects that this way of judging cannot see, or that a free parameter already is.
        closed: what earlier rounds have closed, rms in units of one sample's noise.
        scout: the same records in coarser samples, on which starts are tried.
        signal: standard deviation of the output in units of one sample's noise.
        gap: gap of the recalibrated base model in the same units.
        pairs: stretches that repeat each other, where they were not averaged.
    """

    executor: Executor | None
    repeat_noise: Noise | None
    bin_size: float
    excluded: frozenset[str] = frozenset()
    closed: float = 0.0
    scout: SimulationProblem | None = None
    signal: float = 0.0
    gap: float = 0.0
    pairs: tuple[Pair, ...] = ()

    def rms(self, problem: SimulationProblem, loss: float) -> float:
        """Return what a sum of squares beyond the noise amounts to, rms in units of one sample's noise."""
        return float(np.sqrt(max(0.0, loss) / problem.counted / self.bin_size))

    def alarm(self, options: SearchOptions) -> float:
        """Return the least fall of the held-out loss; noise read off the residual itself is trusted less."""
        unsure = self.repeat_noise is None and self.scout is not None
        return options.alarm * (options.unsure if unsure else 1.0)

    def material(self, options: SearchOptions, present: Sequence[str]) -> float:
        """Return the least closed gap that counts, in units of one sample's noise."""
        chaotic = any(EFFECTS[name].chaotic for name in present)
        tolerance = options.chaotic_form_error if chaotic else options.form_error
        return max(options.material_noise, options.material_signal * self.signal, tolerance * self.closed)
