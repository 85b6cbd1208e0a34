"""How small an effect would have been seen: for the answer `none`, which is worth only as much as this table.

Each effect is put into the fitted joint at its first starting values, with one parameter made smaller. What the joint's
own parameters could imitate is projected out; what is left counts as seen if it would pass the limits of the search:
the alarm over all outputs together, and the least visible amount in one of them at least.
This is the expectation for a linearised fit: a real search may miss a little more.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.ranges import signal_ranges
from discrepancy.effects.spec import Ranges
from discrepancy.effects.table import EFFECTS
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
_HALVINGS = 12


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
    own = _own_directions(problem, state)
    base = problem.flatten(problem.simulate(state.fit.vector, state.fit.starts))
    found = []
    for name, parameter in STRENGTH.items():
        if name in state.present:
            continue
        size = _smallest(problem, state, (name, parameter), (ranges, options, context), (base, own))
        if size is not None:
            known = next(p for p in EFFECTS[name].parameters if p.name == parameter)
            linear = any(c.name.endswith(("_m", "_m_s", "force")) for c in problem.series[0].channels)
            unit = known.kind.value[1 if linear else 0]
            found.append(Detectable(id=name, parameter=parameter, size=size, unit=unit))
    return tuple(found)


def _own_directions(problem: SimulationProblem, state: State) -> FloatArray:
    """Return an orthonormal basis of what the joint's parameters and starting states can imitate, shape (N, r)."""
    at = problem.simulate(state.fit.vector, state.fit.starts)
    columns: list[FloatArray] = list(problem.start_columns(state.fit.vector, state.fit.starts, at))
    flat = problem.flatten(at)
    for parameter in state.fit.parameters:
        moved = state.fit.vector.copy()
        step = 1e-3 * (abs(float(moved[parameter.slot])) or parameter.scale)
        moved[parameter.slot] += step
        columns.append((problem.flatten(problem.simulate(moved, state.fit.starts)) - flat) / step)
    if not columns:
        return np.zeros((flat.size, 0))
    matrix = np.stack([c / max(float(np.linalg.norm(c)), 1e-300) for c in columns], axis=1)
    return np.asarray(np.linalg.qr(matrix)[0])


def _smallest(
    problem: SimulationProblem,
    state: State,
    what: tuple[str, str],
    limits: tuple[Ranges, SearchOptions, Context],
    reference: tuple[FloatArray, FloatArray],
) -> float | None:
    """Return the smallest strength that is seen, by halving; None if the first starting value itself is not seen."""
    name, parameter = what
    ranges, options, context = limits
    base, own = reference
    effect = EFFECTS[name]
    start = dict(effect.starts(ranges)[0])
    slot = next(p.slot for p in effect.parameters if p.name == parameter)
    full = write_start(state.fit.vector, effect, start, state.present)
    for other in effect.parameters:
        if other.name in TWINS and other.name != parameter:
            full[other.slot] = 0.0
    free = sum(1 for p in effect.parameters if p.free)
    need = context.alarm(options) + options.per_parameter * free
    visible = context.material(options, (*state.present, name))

    def seen(size: float) -> bool:
        vector = full.copy()
        vector[slot] = size
        change = problem.flatten(problem.simulate(problem.prepare(vector), state.fit.starts)) - base
        change = change - own @ (own.T @ change)
        each = context.rms(problem, output_losses(problem, change))
        return bool(float(change @ change) > need and np.any(each > visible))

    low, high = 0.0, float(full[slot])
    if high == 0.0 or not seen(high):
        return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if seen(middle) else (middle, high)
    return high
