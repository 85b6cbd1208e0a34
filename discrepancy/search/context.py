"""What a round of the search needs besides data and model, and the limits that follow from it."""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.repeats import Pair
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.problem import Noise, SimulationProblem
from discrepancy.search.options import SearchOptions
from discrepancy.search.outputs import output_counts

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Context:
    """What a round needs besides data and model. Amounts have one number for each output, shape (C,) or (1,).

    Attributes:
        repeat_noise: noise model that repeats show, None without repeats.
        bin_size: variance of one sample over that of a bin (the number of samples in it for white noise).
        excluded: effects that this way of judging cannot see, or that a free parameter already is.
        closed: what earlier rounds have closed, rms in units of one sample's noise.
        scout: the same records in coarser samples, on which starts are tried.
        fine: the same records in finer samples, on which laws with a rough loss are fitted; None without them.
        signal: standard deviation of the output in units of one sample's noise.
        gap: gap of the recalibrated base model in the same units.
        pairs: stretches that repeat each other, where they were not averaged.
    """

    executor: Executor | None
    repeat_noise: Noise | None
    bin_size: FloatArray
    excluded: frozenset[str] = frozenset()
    closed: FloatArray = field(default_factory=lambda: np.zeros(1))
    scout: SimulationProblem | None = None
    fine: SimulationProblem | None = None
    signal: FloatArray = field(default_factory=lambda: np.zeros(1))
    gap: FloatArray = field(default_factory=lambda: np.zeros(1))
    pairs: tuple[Pair, ...] = ()

    def rms(self, problem: SimulationProblem, losses: FloatArray) -> FloatArray:
        """Return what each output's sum of squares beyond the noise amounts to, rms in units of one sample's noise."""
        return np.asarray(np.sqrt(np.maximum(0.0, losses) / output_counts(problem) / self.bin_size))

    def alarm(self, options: SearchOptions) -> float:
        """Return the least fall of the held-out loss; noise read off the residual itself is trusted less."""
        unsure = self.repeat_noise is None and self.scout is not None
        return options.alarm * (options.unsure if unsure else 1.0)

    def least_fall(self, options: SearchOptions, size: int) -> float:
        """Return the least fall of the held-out loss for something with `size` free numbers to be significant."""
        return self.alarm(options) + options.per_parameter * size

    def material(self, options: SearchOptions, present: Sequence[str]) -> FloatArray:
        """Return the least closed gap that counts, in units of one sample's noise, by output."""
        chaotic = any(EFFECTS[name].chaotic for name in present)
        return self._material(options, options.chaotic_form_error if chaotic else options.form_error)

    def least_added(self, options: SearchOptions, present: Sequence[str]) -> FloatArray:
        """Return the least gap that a further effect must close, in units of one sample's noise, by output."""
        chaotic = any(EFFECTS[name].chaotic for name in present)
        return self._material(options, options.chaotic_part if chaotic else options.form_error)

    def _material(self, options: SearchOptions, tolerance: float) -> FloatArray:
        of_signal = options.material_signal * self.signal
        return np.asarray(np.maximum(np.maximum(options.material_noise, of_signal), tolerance * self.closed))
