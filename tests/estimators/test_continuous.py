"""Inversion of the zero-order hold against closed forms and against scipy."""

import re

import numpy as np
import pytest
from scipy.linalg import logm
from scipy.signal import cont2discrete

from estimators.continuous import ContinuousModel, ContinuousRefusal, convert_to_continuous
from estimators.matrix_logarithm import take_logarithm
from estimators.model import DiscreteModel

TS = 0.2


def make_model(a: list[float], b: list[float], delay: int = 1) -> DiscreteModel:
    n = len(a) + len(b)
    return DiscreteModel(
        a=np.array(a),
        b=np.array(b),
        c=np.zeros(0),
        delay=delay,
        covariance=np.zeros((n, n)),
        sample_time_s=TS,
    )


def convert(model: DiscreteModel) -> ContinuousModel:
    converted = convert_to_continuous(model)
    assert isinstance(converted, ContinuousModel), converted
    return converted


def test_first_order_joint_gives_back_gain_and_time_constant() -> None:
    gain, tau = 1.77, 0.885
    decay = np.exp(-TS / tau)
    continuous = convert(make_model([-decay], [gain * (1 - decay)]))
    np.testing.assert_allclose(continuous.denominator, [1.0, 1 / tau], rtol=1e-12)
    np.testing.assert_allclose(continuous.numerator, [gain / tau], rtol=1e-12)


@pytest.mark.parametrize(
    ("numerator", "denominator"),
    [
        ([3.0], [1.0, 2.0, 5.0]),  # oscillating
        ([2.0, 3.0], [1.0, 3.0, 2.0]),  # two real poles and a zero
        ([4.0], [1.0, 4.0, 4.0]),  # a double pole: no basis of eigenvectors
        ([1.0], [1.0, 1.0, 0.0]),  # an integrator
        ([1.0], [1.0, 0.0, 0.0]),  # a double integrator: a Jordan block of size three with the input
        ([1.0, 2.0], [1.0, 6.0, 11.0, 6.0]),  # third order
    ],
)
def test_inversion_undoes_the_hold(numerator: list[float], denominator: list[float]) -> None:
    b, a, _ = cont2discrete((np.array(numerator), np.array(denominator)), TS, method="zoh")
    continuous = convert(make_model(a[1:].tolist(), b.ravel()[1:].tolist()))
    # Multiple roots lose half or two thirds of the digits when the coefficients are rounded.
    np.testing.assert_allclose(continuous.denominator, denominator, atol=2e-5)
    padded = [0.0] * (len(denominator) - 1 - len(numerator)) + numerator
    np.testing.assert_allclose(continuous.numerator, padded, atol=2e-5)


def test_further_delay_becomes_dead_time() -> None:
    continuous = convert(make_model([-0.8], [0.4], delay=4))
    assert continuous.dead_time_s == pytest.approx(3 * TS)
    assert continuous.text == "(2.231) / (s + 1.116) exp(-0.6 s)"


@pytest.mark.parametrize(
    ("a", "b", "reason"),
    [
        ([-0.7292, -0.2702], [0.0770, 0.0985], r"pole at z = -0.2703, on the negative real axis"),  # eq. 24
        ([-0.5, 0.0], [1.0, 0.0], "pole at z = 0: a sampled continuous system has no pole at zero"),
        ([-0.5], [1.0, 0.5], "nb=2 exceeds na=1"),
        ([float("nan")], [1.0], "not finite"),
    ],
)
def test_models_without_a_continuous_counterpart_are_refused_with_the_reason(
    a: list[float], b: list[float], reason: str
) -> None:
    refusal = convert_to_continuous(make_model(a, b))
    assert isinstance(refusal, ContinuousRefusal)
    assert re.search(reason, refusal.reason)


@pytest.mark.parametrize("seed", range(5))
def test_logarithm_agrees_with_scipy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    matrix = np.eye(4) + 0.3 * rng.normal(size=(4, 4))
    found = take_logarithm(matrix @ matrix.T)
    assert found is not None
    np.testing.assert_allclose(found, logm(matrix @ matrix.T), atol=1e-10)


def test_singular_matrix_has_no_logarithm() -> None:
    assert take_logarithm(np.array([[1.0, 0.0], [0.0, 0.0]])) is None
