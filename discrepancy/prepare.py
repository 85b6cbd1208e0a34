"""From records to a recalibrated base model with its noise: what a search begins from."""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from discrepancy.data.ranges import signal_ranges
from discrepancy.data.repeats import find_repeats, merge_as, merge_repeats
from discrepancy.data.series import SPEED, TORQUE, Series, bin_series, cut_windows
from discrepancy.data.timing import timing_bounds
from discrepancy.effects.spec import Ranges
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.levenberg import fit
from discrepancy.fitting.noise import sample_sigma, sigma_or_floor
from discrepancy.fitting.parameters import (
    SMOOTHING_START_S,
    base_parameters,
    effect_parameters,
    model_vector,
    smoothing_parameter,
)
from discrepancy.fitting.problem import Noise, SimulationProblem
from discrepancy.fitting.response import check_response
from discrepancy.model.schema import InputHold, JointModel
from discrepancy.model.structure import parameters_in_disguise
from discrepancy.search.context import Context
from discrepancy.search.fine import scout_problem
from discrepancy.search.noise import measure_noise, residual_parts
from discrepancy.search.outputs import output_losses, output_rows
from discrepancy.search.state import State, with_best_smoothing
from discrepancy.simulation import slots as s
from discrepancy.torque.prepare import torque_problem
from discrepancy.torque.problem import Motion

MOST_SAMPLES = 12_000
FINE_FACTOR = 4
"""Laws with a rough loss are fitted on samples so many times finer than the others."""
SHORTEST_BIN_S = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Prepared:
    """The recalibrated base model and everything the search needs.

    Attributes:
        noise_floor: standard deviation of one sample's noise by output.
        timing: bounds of the input's unknown timing, s; None where the model file states it.
    """

    problem: SimulationProblem
    state: State
    ranges: Ranges
    context: Context
    noise_floor: dict[str, float]
    repeats: int
    factor: int
    timing: tuple[float, float] | None


def choose_bin(train: Sequence[Series]) -> int:
    """Return how many samples are averaged into one."""
    total = sum(one.n for one in train)
    step = train[0].step
    return max(1, min(round(20e-3 / step), max(round(SHORTEST_BIN_S / step), round(total / MOST_SAMPLES))))


def prepare_simulation(model: JointModel, train: Sequence[Series], executor: Executor | None) -> Prepared:
    """Bin the records, recalibrate the base model and measure the noise."""
    factor = choose_bin(train)
    binned = tuple(bin_series(one, factor) for one in train)
    if not any(channel.row == SPEED for channel in binned[0].channels):
        binned = tuple(cut_windows(one, 2.0) for one in binned)
    timing = timing_bounds(model, train[0])
    sigma = {c.name: sigma_or_floor(0.01 * float(np.std(c.values)), c.values) for c in binned[0].channels}
    problem = SimulationProblem(series=binned, noise=Noise(sigma=sigma))
    prepared = _finish_preparation(model, problem, (timing, factor, executor))
    levels = prepared.problem.noise.sigma
    floor = noise_floor(train, prepared.problem)
    channels = binned[0].channels
    ratio = np.array([(floor[c.name] / levels[c.name]) ** 2 for c in channels])
    sizes = [
        float(np.std(np.concatenate([one.channels[c].values for one in binned]))) / floor[channel.name]
        for c, channel in enumerate(channels)
    ]
    left = output_losses(prepared.problem, prepared.state.fit.residual) - output_rows(prepared.problem)
    context = replace(prepared.context, bin_size=ratio, signal=np.array(sizes))
    context = replace(context, fine=fine_problem(prepared.problem, train, factor))
    context = replace(context, gap=context.rms(prepared.problem, left))
    return replace(prepared, noise_floor=floor, context=context)


def _finish_preparation(
    model: JointModel,
    problem: SimulationProblem,
    rest: tuple[tuple[float, float] | None, int, Executor | None],
) -> Prepared:
    """Recalibrate, measure the noise, and look where the residual repeats over the angle."""
    timing, factor, executor = rest
    vector = model_vector(model)
    if model.input_hold is InputHold.HOLD:
        vector[s.INPUT_SHIFT] = 0.5 * problem.series[0].original_step
    check_response(problem, vector)
    ranges = signal_ranges(problem.series, vector)
    base = base_parameters(model, ranges, timing)
    if problem.series[0].channels[0].row == SPEED:
        vector[s.OUTPUT_SMOOTHING] = SMOOTHING_START_S
        base.append(smoothing_parameter())
    present: list[str] = []
    for term in model.effects:
        base.extend(effect_parameters(EFFECTS[term.id], present, ranges))
        present.append(term.id)
    fitted = fit(problem, base, vector, problem.initial_starts())
    state = State(base=tuple(base), given=tuple(present), added=(), fit=fitted, nameplate=vector)
    parts = residual_parts(problem, state)
    pairs = find_repeats(problem.series)
    noise, repeat = measure_noise(problem, parts, pairs)
    problem = replace(problem, noise=noise)
    records = len(problem.series)
    is_torque = problem.series[0].channels[0].row == TORQUE
    if not is_torque:
        problem = replace(problem, series=merge_repeats(problem.series, pairs))
    state = best_of_starts(problem, state)
    ranges = signal_ranges(problem.series, fitted.vector)
    floor = {name: float(value * np.sqrt(factor)) for name, value in noise.sigma.items()}
    return Prepared(
        problem=problem, state=state, ranges=ranges, noise_floor=floor, repeats=len(pairs), timing=timing,
        factor=factor,
        context=Context(
            executor=executor, repeat_noise=repeat, bin_size=np.full(1, float(factor)),
            excluded=parameters_in_disguise(model),
            scout=None if is_torque else scout_problem(problem),
            pairs=tuple(pairs) if len(problem.series) == records else (),
        ),
    )  # fmt: skip


def noise_floor(train: Sequence[Series], problem: SimulationProblem) -> dict[str, float]:
    """Return the noise of one sample of each output at full rate."""
    factor = problem.series[0].factor
    pairs = find_repeats([bin_series(one, factor) for one in train])
    return {
        channel.name: sample_sigma(train, c, factor, problem.noise.sigma[channel.name], pairs)
        for c, channel in enumerate(train[0].channels)
    }


def best_of_starts(problem: SimulationProblem, state: State) -> State:
    """Return the base model fitted from the measured starting speed or from rest: a smoothed speed errs at its ends."""
    starts = problem.initial_starts()
    at_rest = tuple(start * np.array([0.0, 1.0]) for start in starts)
    fits = [fit(problem, state.base, state.fit.vector, one, 15) for one in (starts, at_rest)]
    best = replace(state, fit=min(fits, key=lambda one: one.loss))
    return with_best_smoothing(problem, best)


def fine_problem(problem: SimulationProblem, train: Sequence[Series], factor: int) -> SimulationProblem:
    """Return the problem on finer samples of the same records, cut into the same windows."""
    fine = max(1, factor // FINE_FACTOR)
    if fine == factor or any(len(one.windows) > 1 for one in problem.series):
        return problem
    return replace(problem, series=merge_as([bin_series(one, fine) for one in train], problem.series))


def prepare_torque(
    model: JointModel, train: Sequence[tuple[Motion, Series]], executor: Executor | None
) -> Prepared:
    """Recalibrate the base model on the torque balance and measure the noise."""
    problem = torque_problem(model, train)
    prepared = _finish_preparation(model, problem, (timing_bounds(model, train[0][1]), 1, executor))
    # A torque balance is linear in elementary laws: asymmetric dry friction is named by its parts, level and offset.
    excluded = frozenset(name for name, effect in EFFECTS.items() if not effect.inverse)
    excluded |= {"asymmetric_coulomb_friction"}
    return replace(prepared, context=replace(prepared.context, excluded=excluded | prepared.context.excluded))
