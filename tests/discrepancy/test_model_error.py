"""Standard errors that hold an error of the laws' form, and those of a motion that no linearisation describes."""

from dataclasses import replace

import numpy as np
import pytest

from discrepancy.fitting.problem import SimulationProblem
from discrepancy.model.schema import JointModel
from discrepancy.search.model_error import _mean_square, settle
from discrepancy.search.outcome import SearchOutcome
from discrepancy.search.standard_errors import robust_covariance
from discrepancy.search.stretches import stretch_variances
from discrepancy.simulation import slots as s
from tests.discrepancy.test_standard_errors import fitted, recorded, value

LEVEL = 0.05


def noise_error(outcome: SearchOutcome, name: str) -> float:
    """Return the part of a standard error that is noise."""
    fit = outcome.steps[-1].state.fit
    index = [p.name for p in fit.parameters].index(name)
    return float(np.sqrt(robust_covariance(outcome.problem, fit)[index, index]))


def dry(model: JointModel, more: dict[int, float]) -> SearchOutcome:
    """Fit dry friction to records of a joint that has it, and more that no parameter can take up."""
    return fitted(
        model, recorded(model, {s.COULOMB: LEVEL} | more), "coulomb_friction", {"level": 0.9 * LEVEL}
    )


def test_a_bent_torque_law_that_biases_friction_is_in_its_standard_error(nameplate: JointModel) -> None:
    outcome = dry(nameplate, {s.QUADRATIC: 0.004})
    found, error = value(outcome, "level")
    bias = abs(found - LEVEL)
    assert bias > 2.5 * noise_error(outcome, "level")
    assert bias < 1.96 * error


def test_a_law_that_is_right_keeps_a_standard_error_near_that_of_the_noise(nameplate: JointModel) -> None:
    outcome = dry(nameplate, {})
    found, error = value(outcome, "level")
    assert abs(found - LEVEL) < 2.0 * error
    assert noise_error(outcome, "level") <= error < 2.0 * noise_error(outcome, "level")


def test_a_lag_is_known_no_better_than_the_formula_that_realises_it(nameplate: JointModel) -> None:
    train = recorded(nameplate, {s.FILTER_LAG: 0.06})
    outcome = fitted(nameplate, train, "speed_filter_lag", {"time_constant": 0.05})
    found, error = value(outcome, "time_constant")
    half = train[0].original_step / np.sqrt(12.0)
    assert noise_error(outcome, "time_constant") < 0.5 * half
    assert half <= error < 1.5 * half
    assert abs(found - 0.06) < 1.96 * error


@pytest.fixture
def settled(nameplate: JointModel) -> tuple[SearchOutcome, SimulationProblem]:
    """Return a fit, and its problem in the noise that it leaves."""
    outcome = dry(nameplate, {})
    return outcome, settle(outcome.problem, outcome.steps[-1].state.fit).problem


def test_ends_of_a_smoothed_record_say_nothing_about_its_noise(
    settled: tuple[SearchOutcome, SimulationProblem],
) -> None:
    outcome, _ = settled
    fit = outcome.steps[-1].state.fit
    vector = fit.vector.copy()
    vector[s.OUTPUT_SMOOTHING] = 0.008
    at = replace(fit, vector=vector)
    [one] = outcome.problem.series
    wild = one.channels[0].values.copy()
    wild[:3] += 1.0
    wild[-2:] -= 1.0
    ends = replace(one, channels=(replace(one.channels[0], values=wild),))
    calm, again = (settle(replace(outcome.problem, series=(each,)), at) for each in (one, ends))
    assert again.problem.noise.sigma == calm.problem.noise.sigma
    assert not again.problem.measured()[: again.problem.edge].any()
    assert again.unit == pytest.approx(calm.unit)


def test_stretches_of_a_regular_motion_scatter_as_single_records_do(
    settled: tuple[SearchOutcome, SimulationProblem],
) -> None:
    outcome, _ = settled
    fit = outcome.steps[-1].state.fit
    index = [p.name for p in fit.parameters].index("level")
    scatter = float(np.sqrt(stretch_variances(outcome.problem, fit)[index]))
    # Each of the four stretches knows the level half as well as the whole record, or worse.
    noise = noise_error(outcome, "level")
    assert 0.5 * noise < scatter < 8.0 * noise


def test_stretches_keep_holes_and_need_no_angle(settled: tuple[SearchOutcome, SimulationProblem]) -> None:
    outcome, _ = settled
    [one] = outcome.problem.series
    holed = replace(one, windows=np.array([-1, -301], dtype=np.int64), angle=np.empty(0))
    holed = replace(holed, starts=np.zeros((2, 2)))
    fit = outcome.steps[-1].state.fit
    found = stretch_variances(replace(outcome.problem, series=(holed,)), fit)
    assert found.shape == (len(fit.parameters),)
    assert np.all(np.isfinite(found))


@pytest.mark.parametrize(
    ("seen", "expected"),
    [pytest.param(1e-3, 0.1, id="hardly shown"), pytest.param(1e3, 2.0, id="plainly shown")],
)
def test_a_curve_that_the_records_hardly_show_is_no_larger_than_laws_err(
    seen: float, expected: float
) -> None:
    rng = np.random.default_rng(3)
    columns = seen * rng.normal(size=(4000, 9)) / np.sqrt(4000.0)
    left = columns @ rng.choice([-2.0, 2.0], 9) + rng.normal(size=4000)
    root = np.sqrt(_mean_square(columns, left, (1.0, expected**2 if seen < 1.0 else 100.0)))
    assert root <= expected if seen < 1.0 else root == pytest.approx(expected, rel=0.6)
    assert root > 0.2 * expected
    # Without a limit a curve that nobody sees could be anything.
    assert seen > 1.0 or np.sqrt(_mean_square(columns, left, (1.0, np.inf))) > 100.0 * root
