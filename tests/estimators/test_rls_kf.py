"""RLS-KF in both readings, and its variances by maximum likelihood."""

import numpy as np
import pytest
from numpy.typing import NDArray

from estimators.regressors import Regression
from estimators.rls import RlsOptions, make_rls
from estimators.rls_kf import RlsKfOptions, make_rls_kf
from estimators.rls_kf_literal import make_rls_kf_literal
from estimators.rls_kf_ml import estimate_noise
from estimators.start import NEAR_ZERO, Start
from estimators.structure import ModelStructure

Array = NDArray[np.float64]

# Annual flow of the Nile at Aswan 1871-1970, 1e8 m^3: the worked example of J. Durbin and S. J. Koopman, Time
# Series Analysis by State Space Methods, 2nd ed. 2012, section 2.
NILE = """
1120 1160 963 1210 1160 1160 813 1230 1370 1140 995 935 1110 994 1020 960 1180 799 958 1140 1100 1210 1150
1250 1260 1220 1030 1100 774 840 874 694 940 833 701 916 692 1020 1050 969 831 726 456 824 702 1120 1100 832
764 821 768 845 864 862 698 845 744 796 1040 759 781 865 845 944 984 897 822 1010 771 676 649 846 812 742 801
1040 860 874 848 890 744 749 838 1050 918 986 797 923 975 815 1020 906 901 1170 912 746 919 718 714 740
"""


def test_rls_kf_follows_the_filter_equations_with_the_papers_variances(regression: Regression) -> None:
    estimator = make_rls_kf(4, RlsKfOptions(start=NEAR_ZERO))
    state = estimator.init()
    trace = estimator.run(state, regression.phi, regression.y)
    theta, P = np.full(4, 1e-3), 1e-3 * np.eye(4)
    for k, (row, value) in enumerate(zip(regression.phi, regression.y, strict=True)):
        prior = row @ theta
        # Eq. 13 prints P(k/k-1) on both sides; the right-hand one is P(k-1/k-1).
        P = P + 0.99 * np.eye(4)
        s = row @ P @ row + 0.99
        K = P @ row / s
        theta = theta + K * (value - prior)
        P = P - np.outer(K, row @ P)
        assert (trace.prior[k], trace.variance[k]) == pytest.approx((prior, s), rel=1e-9)
    np.testing.assert_allclose(state.theta, theta, rtol=1e-9)
    np.testing.assert_allclose(state.covariance_factor(), P, rtol=1e-9, atol=1e-12)


def test_literal_reading_follows_algorithm_1_line_by_line(regression: Regression) -> None:
    estimator = make_rls_kf_literal(4, RlsKfOptions(start=Start(p0=1e-3)))
    state = estimator.init()
    trace = estimator.run(state, regression.phi, regression.y)
    theta, P, x = np.zeros(4), 1e-3 * np.eye(4), np.zeros(4)
    for k, (row, value) in enumerate(zip(regression.phi, regression.y, strict=True)):
        predicted = x @ theta
        P = P + 0.99 * np.eye(4)
        K = P @ x / (0.99 + x @ P @ x)
        theta = theta + K * (value - predicted)
        P = (np.eye(4) - np.outer(K, x)) @ P
        x = row
        assert trace.prior[k] == pytest.approx(predicted, rel=1e-8)
    np.testing.assert_allclose(state.theta, theta, rtol=1e-8)


def test_literal_reading_is_the_standard_one_with_a_regressor_one_sample_old(regression: Regression) -> None:
    options = RlsKfOptions(start=Start(p0=1e-3))
    literal, standard = make_rls_kf_literal(4, options), make_rls_kf(4, options)
    one, two = literal.init(), standard.init()
    old = np.vstack([np.zeros((1, 4)), regression.phi[:-1]])
    first = literal.run(one, regression.phi, regression.y)
    second = standard.run(two, old, regression.y)
    np.testing.assert_array_equal(first.prior, second.prior)


def test_missing_minus_signs_of_algorithm_1_only_flip_a1_and_a2(regression: Regression) -> None:
    estimator = make_rls_kf(4, RlsKfOptions(start=Start(p0=1e-3)))
    printed, usual = estimator.init(), estimator.init()
    flipped = regression.phi * np.array([-1.0, -1.0, 1.0, 1.0])
    as_printed = estimator.run(printed, flipped, regression.y)
    as_usual = estimator.run(usual, regression.phi, regression.y)
    np.testing.assert_allclose(as_printed.prior, as_usual.prior, rtol=1e-12)
    np.testing.assert_allclose(printed.theta, usual.theta * [-1, -1, 1, 1], rtol=1e-12)


def test_rls_kf_without_drift_is_rls(regression: Regression) -> None:
    filtered = make_rls_kf(4, RlsKfOptions(rw=0.0, rv=1.0, start=Start(p0=1e6)))
    squares = make_rls(4, RlsOptions(start=Start(p0=1e6)))
    one, two = filtered.init(), squares.init()
    filtered.run(one, regression.phi, regression.y)
    squares.run(two, regression.phi, regression.y)
    assert one == two


def test_paper_variances_make_the_filter_depend_on_the_units(regression: Regression) -> None:
    estimator = make_rls_kf(4, RlsKfOptions())
    metres, millimetres = estimator.init(), estimator.init()
    a_priori = estimator.run(metres, regression.phi, regression.y).prior
    scaled = estimator.run(millimetres, 1e3 * regression.phi, 1e3 * regression.y).prior / 1e3
    assert np.max(np.abs(a_priori[50:] - scaled[50:])) > 0.01


def test_scalar_random_walk_settles_at_the_steady_state_gain() -> None:
    q, r = 0.3, 2.0
    estimator = make_rls_kf(1, RlsKfOptions(rw=q, rv=r, start=Start(p0=1e6)))
    state = estimator.init()
    trace = estimator.run(state, np.ones((200, 1)), np.zeros(200))
    # Positive root of the scalar Riccati equation p^2 - q p - q r = 0.
    p = (q + np.sqrt(q * q + 4 * q * r)) / 2
    assert trace.variance[-1] == pytest.approx(p + r, rel=1e-12)


def test_maximum_likelihood_reproduces_the_published_nile_variances() -> None:
    flow = np.array(NILE.split(), dtype=np.float64)
    level = Regression(
        structure=ModelStructure(na=1, nb=1),
        phi=np.ones((flow.size, 1)),
        y=flow,
        rows=np.arange(flow.size),
        bounds=(slice(0, flow.size),),
    )
    estimate = estimate_noise(level)
    # Durbin and Koopman, section 2.10.3: 15099 and 1469.1, printed with five digits.
    assert estimate.options.rv == pytest.approx(15099, rel=2e-3)
    assert np.atleast_1d(estimate.options.rw)[0] == pytest.approx(1469.1, rel=1e-2)


def test_maximum_likelihood_finds_no_significant_drift_in_a_constant_plant(regression: Regression) -> None:
    estimate = estimate_noise(regression)
    assert estimate.options.rv == pytest.approx(0.1**2, rel=0.2)
    # Twice the gain over constant parameters is about chi-square distributed; 6.6 is its 1 % point.
    assert 0.0 <= 2 * (estimate.log_likelihood - estimate.log_likelihood_constant) < 6.6


def test_maximum_likelihood_finds_the_drift_of_a_drifting_parameter() -> None:
    rng = np.random.default_rng(11)
    n, drift = 4000, 0.02
    phi = rng.normal(size=(n, 1))
    gain = 1.0 + np.cumsum(drift * rng.normal(size=n))
    rows = Regression(
        structure=ModelStructure(na=1, nb=1),
        phi=phi,
        y=phi[:, 0] * gain + 0.5 * rng.normal(size=n),
        rows=np.arange(n),
        bounds=(slice(0, n),),
    )
    estimate = estimate_noise(rows)
    # The relative standard errors of both standard deviations are a few per cent.
    assert np.sqrt(estimate.options.rv) == pytest.approx(0.5, rel=0.05)
    assert np.sqrt(np.atleast_1d(estimate.options.rw)[0]) == pytest.approx(drift, rel=0.2)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"rv": 0.0}, "rv=0.0 must be a positive variance"),
        ({"rw": -1.0}, "rw=-1.0 must be zero"),
        ({"rw": float("nan")}, "rw=nan must be zero"),
    ],
)
def test_impossible_variances_are_refused(options: dict[str, float], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        RlsKfOptions(rw=options.get("rw", 0.99), rv=options.get("rv", 0.99))


def test_drift_for_the_wrong_number_of_parameters_is_refused() -> None:
    with pytest.raises(ValueError, match="rw has 3 values; give one, or 4"):
        make_rls_kf(4, RlsKfOptions(rw=(0.1, 0.1, 0.1)))
