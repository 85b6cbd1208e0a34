"""Figures of merit against numbers worked out by hand."""

import math

import numpy as np
import pytest

from estimators.metrics import adjust_r2, determine_r2, score_series


def test_r2_by_hand() -> None:
    y, predicted = np.array([1.0, 2.0, 3.0, 4.0]), np.array([1.0, 2.5, 3.0, 3.5])
    # Mean 2.5, total 5, missed 0.5.
    assert determine_r2(y, predicted) == pytest.approx(0.9, abs=1e-15)


def test_adjusted_r2_follows_equation_26() -> None:
    # n = 25 observations, p = 4 parameters: 1 - 24 / 20 * 0.1.
    assert adjust_r2(0.9, 25, 4) == pytest.approx(0.88, abs=1e-15)


def test_adjusted_r2_needs_more_observations_than_parameters() -> None:
    assert math.isnan(adjust_r2(0.9, 5, 4))


def test_predicting_the_mean_scores_zero() -> None:
    y = np.array([1.0, 2.0, 6.0])
    assert determine_r2(y, np.full(3, 3.0)) == 0.0


def test_a_resting_output_has_no_r2() -> None:
    assert math.isnan(determine_r2(np.ones(5), np.ones(5)))


def test_a_diverged_prediction_has_no_r2_and_no_warning() -> None:
    score = score_series(np.arange(5.0), np.array([0.0, 1.0, 1e200, np.inf, 2.0]), 1, np.arange(5))
    assert math.isnan(score.r2) and math.isinf(score.rmse)


def test_only_the_given_rows_count() -> None:
    score = score_series(
        np.array([9.0, 1.0, 2.0, 3.0]), np.array([0.0, 1.0, 2.0, 2.0]), 0, np.array([1, 2, 3])
    )
    assert score.n == 3
    assert score.rmse == pytest.approx(math.sqrt(1 / 3))
    assert score.r2 == pytest.approx(0.5)
