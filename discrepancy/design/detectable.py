"""How small an effect would have been seen: for the answer `none`, which is worth only as much as this table.

Each effect is put into the fitted joint at its first starting values, with one parameter made smaller. What the joint's
own parameters could imitate is projected out; what is left counts as seen if it would pass the limits of the search:
the alarm over all outputs together, and the least visible amount in one of them at least.
This is the expectation for a linearised fit: a real search may miss a little more.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.ranges import signal_ranges
from discrepancy.design.information import Growth
from discrepancy.effects.spec import Ranges
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.levenberg import Fit, fit, start_projector
from discrepancy.fitting.parameters import write_start
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.report.pictures import Detectable
from discrepancy.search.context import Context
from discrepancy.search.options import SearchOptions
from discrepancy.search.outputs import output_losses
from discrepancy.search.state import State

FloatArray = NDArray[np.float64]

STRENGTH: Mapping[str, str] = {
    "coulomb_friction": "level",
    "asymmetric_coulomb_friction": "level_positive",
    "asymmetric_viscous_friction": "half_difference",
    "stribeck_friction": "static_excess",
    "quadratic_drag": "coefficient",
    "load_torque_offset": "torque",
    "load_dependent_friction": "coefficient",
    "gravity_unbalance": "sine",
    "torque_ripple": "sine",
    "presliding_hysteresis": "level",
    "viscous_friction_drift": "change",
    "position_dependent_inertia": "sine",
    "torque_constant_drift": "change",
    "transport_delay": "delay",
    "current_loop_lag": "time_constant",
    "inverter_dead_time": "lost_current",
    "current_sensor_offset": "offset",
    "potentiometer_nonlinearity": "sine",
    "speed_filter_lag": "time_constant",
}
"""The parameter that stands for an effect's strength and switches it off at zero; limits and gaps have none."""

TWINS = frozenset({"cosine", "level_negative", "coulomb_level"})
"""Second strengths of the same effects: they stand at zero while the first one is varied."""
_STEPS = 8
_CLOSE = 0.05
"""A strength is found when its distance is the needed one to this part."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Hidden:
    """An effect that the model does not have, put into it.

    Attributes:
        id: of the effect.
        parameter: the one that stands for its strength.
        vector: the kernel's parameters with the effect at full strength.
        slot: of the strength.
        free: number of fitted parameters.
        unit: of the strength.
    """

    id: str
    parameter: str
    vector: FloatArray
    slot: int
    free: int
    unit: str

    @property
    def full(self) -> float:
        """Return the strength of the first starting values, in `unit`."""
        return float(self.vector[self.slot])

    def at(self, size: float) -> FloatArray:
        """Return the kernel's parameters with another strength, in `unit`."""
        vector = self.vector.copy()
        vector[self.slot] = size
        return vector


def hidden_effects(state: State, ranges: Ranges, *, linear: bool) -> list[Hidden]:
    """Return every effect with a strength that a model does not have yet.

    Args:
        state: the model.
        ranges: sizes of the signals, from which the full strengths follow.
        linear: whether the axis is linear, for the units.
    """
    found = []
    for name, parameter in STRENGTH.items():
        if name in state.present:
            continue
        effect = EFFECTS[name]
        vector = write_start(state.fit.vector, effect, effect.starts(ranges)[0], state.present)
        for other in effect.parameters:
            if other.name in TWINS and other.name != parameter:
                vector[other.slot] = 0.0
        known = next(p for p in effect.parameters if p.name == parameter)
        free = sum(1 for p in effect.parameters if p.free)
        unit = known.kind.value[1 if linear else 0]
        if vector[known.slot] != 0.0:  # zero: the effect shares its strength with one that is present
            found.append(
                Hidden(id=name, parameter=parameter, vector=vector, slot=known.slot, free=free, unit=unit)
            )
    return found


class Sight:
    """How far hidden effects stand out of a set of records, beside a model fitted to them.

    Attributes:
        fit: the model beside the records, not moved.
        normal: information about its parameters, scaled coordinates, shape (p, p).
        signal: standard deviation of the outputs in units of one sample's noise, rms over outputs.
    """

    def __init__(self, problem: SimulationProblem, state: State, context: Context) -> None:
        """Simulate the model and its sensitivities once.

        Args:
            problem: with the noise's weights.
            state: the fitted model.
            context: what the search knew of noise and size of each output.
        """
        starts = state.fit.starts
        self.problem, self.context, self.present = problem, context, state.present
        self.bin_size = float(np.mean(context.bin_size))
        self.fit: Fit = fit(problem, state.fit.parameters, state.fit.vector, starts, 0)
        self.normal = self.fit.normal()
        self._projector = start_projector(problem, self.fit)
        self._base = problem.flatten(problem.simulate(self.fit.vector, starts))
        self.signal = signal_of(problem, self.bin_size)

    def change(self, vector: FloatArray) -> FloatArray:
        """Return what other parameters change in the flattened outputs, starting states projected out, shape (N,)."""
        problem = self.problem
        moved = problem.flatten(problem.simulate(problem.prepare(vector), self.fit.starts))
        return self._projector.project(np.nan_to_num(moved - self._base))

    def sums(self, vector: FloatArray) -> Growth:
        """Return the sums over the records for parameters that a refitted model would have to follow, K = 1."""
        change = self.change(vector)
        gradient = self.fit.jacobian.T @ change
        return Growth(
            normal=self.normal[None], gradient=gradient[None], loss=np.array([float(change @ change)])
        )

    def shown(self, one: Hidden, size: float, options: SearchOptions) -> float:
        """Return how much of what the search asks for an effect of this size shows: from 1 on it is named.

        Grows with about the square of the size, which is in the effect's unit.
        """
        jacobian, change = self.fit.jacobian, self.change(one.at(size))
        # What the model's own parameters follow when they are fitted again.
        left = change - jacobian @ (np.linalg.pinv(self.normal, rcond=1e-14) @ (jacobian.T @ change))
        need = self.context.least_fall(options, one.free)
        each = self.context.rms(self.problem, output_losses(self.problem, left))
        visible = self.context.material(options, (*self.present, one.id))
        return min(float(left @ left) / need, float(np.max((each / visible) ** 2)))


def signal_of(problem: SimulationProblem, bin_size: float) -> float:
    """Return the outputs' standard deviation in units of one sample's noise, rms over outputs."""
    first = problem.series[0]
    noise = [problem.noise.sigma[c.name] * np.sqrt(bin_size) for c in first.channels]
    sizes = [float(np.std(c.values)) for c in first.channels]
    return float(np.sqrt(np.mean([(size / sigma) ** 2 for size, sigma in zip(sizes, noise, strict=True)])))


def detectable_effects(
    problem: SimulationProblem, state: State, options: SearchOptions, context: Context
) -> tuple[Detectable, ...]:
    """Return for each effect with a strength the smallest one that would have been seen.

    Args:
        problem: with the noise's weights.
        state: the recalibrated base model.
        options: limits of the search.
        context: what the search knew of noise and size of each output.
    """
    ranges = signal_ranges(problem.series, state.fit.vector)
    linear = any(c.name.endswith(("_m", "_m_s", "force")) for c in problem.series[0].channels)
    sight = Sight(problem, state, context)
    found = []
    for one in hidden_effects(state, ranges, linear=linear):
        size = smallest_seen(sight, one, options)
        if size is not None:
            found.append(Detectable(id=one.id, parameter=one.parameter, size=size, unit=one.unit))
    return tuple(found)


def smallest_seen(sight: Sight, one: Hidden, options: SearchOptions) -> float | None:
    """Return the smallest strength that is seen, in its unit; None if the full one itself is not.

    What shows grows with about the square of the strength: that is the next guess, kept between what is seen and what
    is not.
    """
    shown = sight.shown(one, one.full, options)
    if shown <= 1.0:
        return None
    low, part, high = 0.0, 1.0, 1.0
    for _ in range(_STEPS):
        part /= float(np.sqrt(max(shown, 1e-300)))
        part = part if low < part < high else 0.5 * (low + high)
        shown = sight.shown(one, part * one.full, options)
        low, high = (low, part) if shown > 1.0 else (part, high)
        if 1.0 < shown < 1.0 + _CLOSE:
            break
    return high * one.full
