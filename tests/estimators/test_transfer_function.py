"""Transfer functions, poles and static gains; among them the paper's printed ones, with the right reading."""

import numpy as np
import pytest

from estimators.dataset import Dataset
from estimators.model import (
    DiscreteModel,
    model_from_theta,
    predict_one_step,
    shift_by_one,
    simulate_free_run,
)
from estimators.structure import ModelStructure
from estimators.transfer_function import describe_poles, find_static_gain, form_transfer_function

RLS_THETA = (-1.8279, 0.8279, -0.0054, 0.0201)  # eq. 19
ERLS_THETA = (-1.9517, 0.9517, -0.0058, 0.0121, -0.5964)  # eq. 21
RLS_KF_THETA = (-0.7292, -0.2702, 0.0770, 0.0985)  # eq. 24


def make_model(theta: tuple[float, ...], delay: int = 1, std: float = 0.0, nc: int = 0) -> DiscreteModel:
    n = len(theta)
    structure = ModelStructure(na=(n - nc) // 2, nb=n - nc - (n - nc) // 2, delay=delay, nc=nc)
    return model_from_theta(np.array(theta), std**2 * np.eye(n), structure, 0.2)


def test_equation_20_is_the_transfer_function_of_equation_19() -> None:
    text = form_transfer_function(make_model(RLS_THETA)).text
    assert text == "(-0.0054 z + 0.0201) / (z^2 - 1.828 z + 0.8279)"


def test_equation_23_is_the_transfer_function_of_equation_21() -> None:
    text = form_transfer_function(make_model(ERLS_THETA, nc=1)).text
    assert text == "(-0.0058 z + 0.0121) / (z^2 - 1.952 z + 0.9517)"


def test_equation_25_must_have_minus_0_2702_as_theta_of_equation_24_has() -> None:
    tf = form_transfer_function(make_model(RLS_KF_THETA))
    # The paper prints z^2 - 0.7292 z + 0.2702, which is another plant.
    assert tf.denominator == (1.0, -0.7292, -0.2702)
    poles = sorted(np.roots(tf.denominator))
    assert poles == pytest.approx([-0.2703, 0.9995], abs=5e-5)
    assert find_static_gain(make_model(RLS_KF_THETA)).value == pytest.approx(292.5, rel=1e-3)
    printed = np.roots([1.0, -0.7292, 0.2702])
    assert sorted(printed.imag) == pytest.approx([-0.3705, 0.3705], abs=1e-4)


@pytest.mark.parametrize(("theta", "nc"), [(RLS_THETA, 0), (ERLS_THETA, 1)])
def test_printed_rls_and_erls_models_integrate_and_cannot_be_simulated(
    theta: tuple[float, ...], nc: int
) -> None:
    model = make_model(theta, std=1e-3, nc=nc)
    assert describe_poles(model)[0].magnitude == pytest.approx(1.0, abs=1e-9)
    assert not model.simulable
    assert not find_static_gain(model).determined


def test_literal_algorithm_1_has_a_third_order_transfer_function() -> None:
    shifted = shift_by_one(make_model(RLS_KF_THETA, std=0.5))
    tf = form_transfer_function(shifted)
    assert tf.denominator == (1.0, 0.0, -0.7292, -0.2702)
    assert tf.numerator == (0.0770, 0.0985)
    assert shifted.delay == 2
    np.testing.assert_array_equal(np.diag(shifted.covariance), [0.0, 0.25, 0.25, 0.25, 0.25])


@pytest.mark.parametrize(
    ("theta", "delay", "numerator", "denominator"),
    [
        ((-0.5, 2.0), 1, (2.0,), (1.0, -0.5)),
        ((-0.5, 2.0), 3, (2.0,), (1.0, -0.5, 0.0, 0.0)),
        ((-0.5, 0.1, 2.0, 3.0), 2, (2.0, 3.0), (1.0, -0.5, 0.1, 0.0)),
    ],
)
def test_any_order_and_delay(
    theta: tuple[float, ...], delay: int, numerator: tuple[float, ...], denominator: tuple[float, ...]
) -> None:
    tf = form_transfer_function(make_model(theta, delay))
    assert (tf.numerator, tf.denominator) == (numerator, denominator)


def test_transfer_function_answers_as_the_simulation_does() -> None:
    model = make_model((-1.2, 0.4, 0.3, -0.1), delay=2)
    step = Dataset(u=np.ones(300), y=np.zeros(300), sample_time_s=0.2)
    final = simulate_free_run(model, step)[-1]
    tf = form_transfer_function(model)
    assert final == pytest.approx(sum(tf.numerator) / sum(tf.denominator), rel=1e-12)
    assert final == pytest.approx(find_static_gain(model).value, rel=1e-12)


def test_errors_of_poles_and_gain_agree_with_random_parameters() -> None:
    theta, std = (-1.5, 0.7, 1.0, 0.5), 2e-4
    model = make_model(theta, std=std)
    draws = np.array(theta) + std * np.random.default_rng(0).normal(size=(4000, 4))
    roots = np.array([np.roots([1.0, *draw[:2]]) for draw in draws])
    upper = roots[np.arange(4000), np.argmax(roots.imag, axis=1)]
    gains = draws[:, 2:].sum(axis=1) / (1 + draws[:, :2].sum(axis=1))
    pole = next(pole for pole in describe_poles(model) if pole.im > 0)
    # Standard deviations of 4000 draws scatter by 1.1 %.
    assert pole.std_re == pytest.approx(upper.real.std(), rel=0.05)
    assert pole.std_im == pytest.approx(upper.imag.std(), rel=0.05)
    assert pole.std_magnitude == pytest.approx(np.abs(upper).std(), rel=0.05)
    assert find_static_gain(model).std == pytest.approx(gains.std(), rel=0.05)


def test_one_step_prediction_with_residual_terms_filters_by_one_over_c() -> None:
    rng = np.random.default_rng(5)
    record = Dataset(u=rng.normal(size=50), y=rng.normal(size=50), sample_time_s=0.2)
    model = make_model((-0.5, 1.0, 0.4), nc=1)
    predicted = predict_one_step(model, record)
    residual = 0.0
    for k in range(1, 50):
        expected = 0.5 * record.y[k - 1] + 1.0 * record.u[k - 1] + 0.4 * residual
        assert predicted[k] == pytest.approx(expected, rel=1e-12)
        residual = record.y[k] - expected


def test_free_run_starts_anew_from_measured_outputs_after_a_hole() -> None:
    y = np.concatenate([np.full(5, 8.0), np.full(5, -4.0)])
    record = Dataset(u=np.zeros(10), y=y, sample_time_s=0.2, starts=(0, 5))
    out = simulate_free_run(make_model((-0.5, 1.0)), record)
    np.testing.assert_allclose(out, [np.nan, 4.0, 2.0, 1.0, 0.5, np.nan, -2.0, -1.0, -0.5, -0.25])


def test_a_divergent_free_run_ends_in_infinity_without_raising() -> None:
    record = Dataset(u=np.ones(5000), y=np.ones(5000), sample_time_s=0.2)
    assert not np.isfinite(simulate_free_run(make_model((-2.0, 1.0)), record)[-1])
