"""Fits that are corrected for binning, and standard errors that hold more than noise."""

from dataclasses import replace

import numpy as np
import pytest

from discrepancy.data.ranges import signal_ranges
from discrepancy.data.repeats import find_repeats, merge_as, merge_repeats
from discrepancy.data.series import Series, bin_index, bin_series, read_series
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.levenberg import fit
from discrepancy.fitting.parameters import (
    NUISANCES,
    TIMING,
    base_parameters,
    effect_parameters,
    model_vector,
    smoothing_parameter,
    write_start,
)
from discrepancy.fitting.problem import Noise, SimulationProblem
from discrepancy.model.schema import JointModel
from discrepancy.search.context import Context
from discrepancy.search.full_rate import refine_full_rate
from discrepancy.search.outcome import SearchOutcome, Step
from discrepancy.search.standard_errors import robust_covariance, standard_errors
from discrepancy.search.state import State, with_best_smoothing
from discrepancy.simulation import slots as s
from tests.discrepancy.recorder import make_recording

NOISE = 1e-3
FACTOR = 8
TIMING_RANGE_S = (-1e-3, 3e-3)


def recorded(model: JointModel, changes: dict[int, float]) -> list[Series]:
    """Return two repeats at full rate."""
    return [
        read_series(make_recording(changes, seed, noise=NOISE), model, f"train[{seed}]") for seed in (0, 1)
    ]


def fitted(
    model: JointModel, train: list[Series], effect: str, start: dict[str, float], timed: bool = False
) -> SearchOutcome:
    """Fit one known effect to the averaged repeats in coarse bins, as a search would end."""
    binned = [bin_series(one, FACTOR) for one in train]
    problem = SimulationProblem(
        series=merge_repeats(binned, find_repeats(binned)),
        noise=Noise(sigma={"speed_rad_s": NOISE / np.sqrt(FACTOR)}),
    )
    ranges = signal_ranges(binned, model_vector(model))
    base = base_parameters(model, ranges, TIMING_RANGE_S if timed else None)
    vector = write_start(model_vector(model), EFFECTS[effect], start, ())
    parameters = [*base, *effect_parameters(EFFECTS[effect], (), ranges)]
    done = fit(problem, parameters, vector, problem.initial_starts(), 30)
    state = State(base=tuple(base), given=(), added=(effect,), fit=done)
    return SearchOutcome(
        steps=(Step(state=state, added=effect),),
        rounds=(),
        problem=problem,
        ranges=ranges,
        context=Context(executor=None, repeat_noise=problem.noise, bin_size=np.full(1, float(FACTOR))),
        names={},
    )


def value(outcome: SearchOutcome, name: str) -> tuple[float, float]:
    """Return a parameter of the last model and its standard error."""
    state = outcome.steps[-1].state
    errors = standard_errors(outcome.problem, state.fit, (outcome.bench(state), outcome.ranges))
    index = [p.name for p in state.fit.parameters].index(name)
    return float(state.fit.values[index]), float(errors[index])


def test_the_full_rate_takes_away_what_binning_does_to_a_soft_shaft(nameplate: JointModel) -> None:
    hidden = {s.LOAD_SHARE: 0.8, s.STIFFNESS: 60.0, s.DAMPING_RATIO: 0.15, s.LOAD_FRICTION_SHARE: 0.6}
    start = {"load_share": 0.8, "stiffness": 55.0, "damping_ratio": 0.2, "friction_share": 0.5}
    train = recorded(nameplate, hidden)
    coarse = fitted(nameplate, train, "belt_compliance", start)
    fine = refine_full_rate(coarse, train)
    biased, right = value(coarse, "damping_ratio")[0], value(fine, "damping_ratio")
    assert abs(right[0] - 0.15) < 0.25 * abs(biased - 0.15)
    assert abs(right[0] - 0.15) < 3.0 * right[1]
    assert right[1] < 0.03 * 0.15
    whole = replace(coarse, problem=replace(coarse.problem, series=tuple(train)))
    assert refine_full_rate(whole, train) is whole


def test_a_delay_is_known_no_better_than_the_timing_of_the_input(nameplate: JointModel) -> None:
    train = recorded(nameplate, {s.DELAY: 0.05})
    outcome = fitted(nameplate, train, "transport_delay", {"delay": 0.04}, timed=True)
    found, error = value(outcome, "delay")
    spread = (TIMING_RANGE_S[1] - TIMING_RANGE_S[0]) / np.sqrt(12.0)
    assert spread <= error < 2.1 * spread
    assert abs(found - 0.05) < 2.0 * error
    state = outcome.steps[-1].state
    names = [p.name for p in state.fit.parameters]
    held = np.sqrt(np.diag(robust_covariance(outcome.problem, state.fit, NUISANCES)))
    assert held[names.index("delay")] < 0.05 * spread
    assert held[names.index(TIMING)] == 0.0


def test_a_smoothing_that_was_lost_is_found_again(nameplate: JointModel) -> None:
    train = recorded(nameplate, {s.OUTPUT_SMOOTHING: 0.0})
    outcome = fitted(nameplate, train, "coulomb_friction", {"level": 0.01})
    state, problem = outcome.steps[-1].state, outcome.problem
    vector = state.fit.vector.copy()
    vector[s.OUTPUT_SMOOTHING] = 0.012
    smooth = problem.simulate(vector, state.fit.starts)
    [one] = problem.series
    shown = replace(one, channels=(replace(one.channels[0], values=smooth[0][0]),))
    problem = replace(problem, series=(shown,))
    vector[s.OUTPUT_SMOOTHING] = 1e-3
    lost = fit(problem, [*state.fit.parameters, smoothing_parameter()], vector, state.fit.starts, 5)
    assert lost.vector[s.OUTPUT_SMOOTHING] == pytest.approx(1e-3)
    again = with_best_smoothing(problem, replace(state, fit=lost), 8)
    assert again.fit.vector[s.OUTPUT_SMOOTHING] == pytest.approx(0.012, rel=0.05)


def test_bins_and_groups_are_the_same_at_both_rates(nameplate: JointModel) -> None:
    train = recorded(nameplate, {})
    binned = [bin_series(one, FACTOR) for one in train]
    [merged] = merge_repeats(binned, find_repeats(binned))
    [full] = merge_as(train, (merged,))
    assert bin_series(full, FACTOR).channels[0].values == pytest.approx(merged.channels[0].values)
    holed = replace(train[0], windows=np.array([-1, -101, -111, -1001], dtype=np.int64))
    index, kept = bin_index(holed, FACTOR)
    assert kept == [0, 2, 3]
    assert index.shape == (sum((b - a) // FACTOR for a, b in np.array(holed.edges)[kept]), FACTOR)
    assert index[12, 0] == 110
    assert list(bin_series(replace(holed, starts=np.zeros((4, 2))), FACTOR).windows) == [-1, -13, -124]
