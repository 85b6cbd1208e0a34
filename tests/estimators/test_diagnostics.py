"""Residual tests, excitation report, and the choice of order and delay."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import chi2

from estimators.dataset import Dataset
from estimators.excitation import ExcitationReport, report_excitation
from estimators.regressors import build_regression
from estimators.residuals import analyse_residuals, survive_chi_square
from estimators.selection import select_order
from estimators.settings import IdentifyOptions
from estimators.structure import ModelStructure

Array = NDArray[np.float64]


@pytest.mark.parametrize("freedom", [1, 2, 3, 10, 25, 40])
@pytest.mark.parametrize("x", [1e-6, 0.5, 9.0, 60.0, 400.0])
def test_chi_square_tail_agrees_with_scipy(freedom: int, x: float) -> None:
    assert survive_chi_square(x, freedom) == pytest.approx(float(chi2.sf(x, freedom)), rel=1e-11)


def test_white_residuals_are_called_white_at_the_stated_rate() -> None:
    rng = np.random.default_rng(0)
    n, whole = 400, (slice(0, 400),)
    verdicts = [
        analyse_residuals(rng.normal(size=n), rng.normal(size=n), whole, 20).white for _ in range(500)
    ]
    # 1 % false alarms: five in 500, more than 15 with probability 1e-4.
    assert 0.97 <= np.mean(verdicts) < 1.0


def test_autocorrelation_of_a_first_order_residual_is_found() -> None:
    rng = np.random.default_rng(1)
    e = rng.normal(size=20_001)
    residual = e[1:] + 0.5 * e[:-1]
    report = analyse_residuals(residual, rng.normal(size=20_000), (slice(0, 20_000),), 10)
    # Moving average: 0.5 / (1 + 0.25) at lag 1, zero beyond.
    assert report.autocorrelation[0] == pytest.approx(0.4, abs=0.02)
    assert not report.white
    assert report.input_explained


@pytest.mark.parametrize(("lag", "explained"), [(3, False), (-3, True)])
def test_cross_correlation_tells_missing_dynamics_from_feedback(lag: int, explained: bool) -> None:
    rng = np.random.default_rng(2)
    u = rng.normal(size=2000)
    report = analyse_residuals(np.roll(u, lag) + rng.normal(size=2000), u, (slice(0, 2000),), 10)
    assert report.cross_correlation[10 + lag] == pytest.approx(np.sqrt(0.5), abs=0.05)
    assert report.input_explained is explained


def test_residuals_are_not_correlated_across_a_hole() -> None:
    residual = np.tile([1.0, -1.0], 50)
    whole = analyse_residuals(residual, residual, (slice(0, 100),), 1)
    pairs = tuple(slice(k, k + 1) for k in range(100))
    assert whole.autocorrelation[0] == pytest.approx(-0.99)
    assert analyse_residuals(residual, residual, pairs, 1).autocorrelation[0] == 0.0


def examine(u: Array, y: Array, order: int = 2) -> ExcitationReport:
    record = Dataset(u=u, y=y, sample_time_s=0.2)
    return report_excitation(record, build_regression(record, ModelStructure(na=order, nb=order)))


@pytest.mark.parametrize(
    ("u", "order"),
    [
        (np.zeros(500), 0),
        (np.ones(500), 1),
        (np.sin(0.3 * np.arange(500)), 2),
        (np.sin(0.3 * np.arange(500)) + np.sin(1.1 * np.arange(500)), 4),
        (1 + np.sin(0.3 * np.arange(500)), 3),
        (np.random.default_rng(0).normal(size=500), 20),
    ],
    ids=["silent", "constant", "sine", "two sines", "sine and offset", "white"],
)
def test_persistent_excitation_order_counts_the_spectral_lines(u: Array, order: int) -> None:
    report = examine(u, np.random.default_rng(1).normal(size=500))
    assert report.persistent_excitation_order == order


def test_a_slow_joint_determines_only_the_sum_of_a1_and_a2() -> None:
    rng = np.random.default_rng(3)
    y = np.sin(0.01 * np.arange(4000)) + 1e-5 * rng.normal(size=4000)
    report = examine(rng.normal(size=4000), y)
    assert report.collinear == ("a1", "a2")
    assert report.determined == ("a2 + a1",) or report.determined == ("a1 + a2",)
    assert "is determined well, not each one by itself" in report.sentences[-1]


def test_well_excited_data_can_tell_parameters_apart(noisy_record: Dataset) -> None:
    report = examine(noisy_record.u, noisy_record.y)
    assert report.collinear == ()
    assert report.sentences == (
        "The input is persistently exciting of order at least 20; the model asks for 4.",
        f"The regressors' condition number is {report.condition_number:.3g}: "
        "the parameters can be told apart.",
    )


def test_a_dead_input_is_named() -> None:
    report = examine(np.zeros(100), np.random.default_rng(0).normal(size=100))
    assert "The regressor of b0 is zero throughout: nothing is known of it." in report.sentences


@pytest.mark.parametrize(
    ("a", "b", "delay", "order"),
    [((-0.8,), (0.4,), 2, 1), ((-1.5, 0.7), (1.0, 0.5), 1, 2), ((-1.5, 0.7), (1.0, 0.5), 3, 2)],
)
def test_order_and_delay_of_the_plant_are_ranked_first(
    simulate: Callable[..., Array], a: tuple[float, ...], b: tuple[float, ...], delay: int, order: int
) -> None:
    rng = np.random.default_rng(4)
    u = rng.normal(size=1500)
    clean = simulate(u, a=a, b=b, delay=delay)
    record = Dataset(u=u, y=clean + 0.1 * clean.std() * rng.normal(size=1500), sample_time_s=0.2)
    best = select_order(record, IdentifyOptions()).best
    assert best is not None
    assert (best.order, best.delay) == (order, delay)


def test_no_order_is_best_when_nothing_can_be_simulated() -> None:
    growing = Dataset(u=np.ones(200), y=np.power(1.05, np.arange(200.0)), sample_time_s=0.2)
    assert select_order(growing, IdentifyOptions(), max_order=1, max_delay=1).best is None
