"""The whole comparison: what it finds, what it says, and what it writes."""

import json
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from estimators.dataset import Dataset
from estimators.identify import identify
from estimators.result import IdentificationResult, Mode, Phase
from estimators.settings import IdentifyOptions
from estimators.table import ESTIMATORS
from estimators.verdict import format_r2

Array = NDArray[np.float64]
QUICK = IdentifyOptions(select_order=False)


def read_r2(result: IdentificationResult, mode: Mode, phase: Phase = Phase.TEST) -> dict[str, float]:
    return {name: method.scores[phase][mode].r2_adjusted for name, method in result.methods.items()}


def test_a_posteriori_output_flatters_rls_kf_and_free_run_does_not(
    joint_records: tuple[Dataset, Dataset],
) -> None:
    result = identify(*joint_records, QUICK)
    posterior, free = read_r2(result, Mode.A_POSTERIORI), read_r2(result, Mode.FREE_RUN)
    assert max(posterior, key=lambda name: posterior[name]) == "rls_kf"
    assert min(free, key=lambda name: free[name]) == "rls_kf"


def test_a_start_near_zero_starves_rls_and_feeds_the_papers_ranking(
    joint_records: tuple[Dataset, Dataset],
) -> None:
    fed = read_r2(identify(*joint_records, QUICK), Mode.A_PRIORI, Phase.TRAINING)
    starved = read_r2(
        identify(*joint_records, replace(QUICK, start_near_zero=True)), Mode.A_PRIORI, Phase.TRAINING
    )
    assert starved["rls_kf"] > starved["rls"] and starved["rls_kf"] > starved["erls"]
    assert fed["rls"] > fed["rls_kf"]
    assert 1 - starved["rls"] > 10 * (1 - fed["rls"])


def test_estimated_variances_make_rls_kf_a_competitor(joint_records: tuple[Dataset, Dataset]) -> None:
    result = identify(*joint_records, replace(QUICK, methods=("rls", "rls_kf", "rls_kf_ml")))
    free = read_r2(result, Mode.FREE_RUN)
    assert 1 - free["rls_kf_ml"] < 0.7 * (1 - free["rls_kf"])


def test_trivial_prediction_is_the_yardstick(joint_records: tuple[Dataset, Dataset]) -> None:
    train, test = joint_records
    trivial = identify(train, test, QUICK).trivial[Phase.TEST]
    y = test.y[3:]
    by_hand = 1 - np.sum((y - test.y[2:-1]) ** 2) / np.sum((y - y.mean()) ** 2)
    assert trivial.r2 == pytest.approx(by_hand, rel=1e-12)
    assert trivial.r2_adjusted == pytest.approx(1 - (y.size - 1) / (y.size - 1) * (1 - by_hand), rel=1e-12)


def test_verdict_is_made_from_the_numbers_of_this_table(joint_records: tuple[Dataset, Dataset]) -> None:
    result = identify(*joint_records, QUICK)
    free, trivial = read_r2(result, Mode.FREE_RUN), result.trivial[Phase.TEST].r2_adjusted
    first, second, third = result.verdict
    for name, method in result.methods.items():
        assert f"{method.title} ({format_r2(free[name])})" in first
    assert format_r2(trivial) in second
    assert "a one-step figure near 1 is no evidence of a model" in second
    posterior = format_r2(read_r2(result, Mode.A_POSTERIORI)["rls_kf"])
    assert third.startswith(f"The a-posteriori figure of RLS-KF ({posterior}) is no achievement")


def test_verdict_names_a_model_that_cannot_be_simulated() -> None:
    rng = np.random.default_rng(0)
    u = rng.normal(size=400)
    drifting = Dataset(u=u, y=np.concatenate([[0.0], np.cumsum(u[:-1])]), sample_time_s=0.2)
    result = identify(drifting, drifting, replace(QUICK, order=1, methods=("ls",)))
    assert "LS (largest pole 1)" in result.verdict[0]
    assert "cannot be simulated" in result.verdict[0]
    assert "on or outside the unit circle" in result.methods["ls"].warnings[0]


def test_test_data_do_not_influence_the_parameters(joint_records: tuple[Dataset, Dataset]) -> None:
    train, test = joint_records
    other = Dataset(u=test.u, y=-3.0 * test.y, sample_time_s=0.2)
    one, two = identify(train, test, QUICK), identify(train, other, QUICK)
    for name in QUICK.methods:
        np.testing.assert_array_equal(one.methods[name].theta, two.methods[name].theta)


def test_frozen_figures_use_the_parameters_at_the_end_of_training(
    noisy_record: Dataset, simulate: Callable[..., Array]
) -> None:
    u = np.random.default_rng(9).normal(size=100)
    test = Dataset(u=u, y=simulate(u), sample_time_s=0.2)
    method = identify(noisy_record, test, replace(QUICK, methods=("rls",))).methods["rls"]
    a1, a2, b0, b1 = method.theta
    expected = -a1 * test.y[49] - a2 * test.y[48] + b0 * u[49] + b1 * u[48]
    assert method.series[Phase.TEST][Mode.ONE_STEP_FROZEN][50] == pytest.approx(expected, rel=1e-12)
    assert method.series[Phase.TEST][Mode.A_PRIORI][50] != pytest.approx(expected, rel=1e-6)


def test_holes_in_a_record_change_nothing_but_the_rows_lost(simulate: Callable[..., Array]) -> None:
    u = np.random.default_rng(6).normal(size=1000)
    y = simulate(u)
    keep = np.r_[0:300, 340:1000]
    record = Dataset(u=u[keep], y=y[keep], sample_time_s=0.2, starts=(0, 300))
    result = identify(record, record, replace(QUICK, methods=tuple(ESTIMATORS)))
    for name in ("rls", "rls_directional", "rls_kf_ml", "ls", "iv"):
        np.testing.assert_allclose(result.methods[name].theta, [-1.5, 0.7, 1.0, 0.5], atol=1e-6, err_msg=name)
    assert result.methods["ls"].scores[Phase.TRAINING][Mode.FREE_RUN].n == 960 - 2 * 3


def test_result_is_json_with_every_method_of_the_table(noisy_record: Dataset) -> None:
    result = identify(noisy_record, noisy_record, IdentifyOptions(methods=tuple(ESTIMATORS)))
    document = json.loads(json.dumps(result.to_dict(), allow_nan=False))
    assert document["schema"] == "jointscope.identification/1"
    assert list(document["methods"]) == list(ESTIMATORS)
    rls = document["methods"]["rls"]
    assert [parameter["name"] for parameter in rls["parameters"]] == ["a1", "a2", "b0", "b1"]
    assert set(rls["scores"]["test"]) == {"a_priori", "a_posteriori", "one_step_frozen", "free_run"}
    assert document["methods"]["ls"]["scores"]["test"]["a_priori"] is None
    assert len(rls["series"]["training"]["free_run"]) == noisy_record.n
    assert rls["series"]["training"]["free_run"][:2] == [None, None]
    assert rls["series"]["test"]["a_priori"][50] == pytest.approx(
        result.methods["rls"].series[Phase.TEST][Mode.A_PRIORI][50], abs=1e-5
    )
    assert document["selection"]["best"]["order"] == 2


def test_parameters_carry_standard_errors_poles_and_gain(noisy_record: Dataset) -> None:
    method = identify(noisy_record, noisy_record, replace(QUICK, methods=("rls",))).methods["rls"]
    assert np.all(np.abs(method.theta - [-1.5, 0.7, 1.0, 0.5]) < 4 * method.standard_errors)
    assert method.poles[0].magnitude == pytest.approx(math.sqrt(0.7), abs=4 * method.poles[0].std_magnitude)
    assert method.static_gain.value == pytest.approx(7.5, abs=4 * method.static_gain.std)
    assert method.static_gain.determined


def test_computing_time_comes_from_the_given_clock(noisy_record: Dataset) -> None:
    ticks = iter(range(100))
    result = identify(noisy_record, noisy_record, QUICK, clock=lambda: float(next(ticks)))
    assert [method.computing_time_s for method in result.methods.values()] == [1.0, 1.0, 1.0]


def test_records_of_different_sample_times_are_refused(noisy_record: Dataset) -> None:
    other = Dataset(u=noisy_record.u, y=noisy_record.y, sample_time_s=0.1)
    with pytest.raises(ValueError, match=r"sampled every 0.2 s and test data every 0.1 s"):
        identify(noisy_record, other, QUICK)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.99778, "0.9978"),
        (0.5, "0.500"),
        (0.999976, "0.999976"),
        (-3.25, "-3.250"),
        (math.nan, "none"),
        (1.0, "1.0000"),
        (-1e248, "below -100"),
    ],
)
def test_r2_is_written_with_the_digits_its_distance_from_one_needs(value: float, text: str) -> None:
    assert format_r2(value) == text
