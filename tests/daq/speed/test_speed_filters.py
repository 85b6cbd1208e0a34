"""Speed from position: exact on straight lines, as noisy as computed, the same however the data are cut."""

import numpy as np
import numpy.typing as npt
import pytest

from daq.speed.filters import (
    SPEED_METHODS,
    CausalSpeedFilter,
    describe_zero_phase,
    speed_from_position_zero_phase,
)
from daq.speed.kalman import KalmanSpeed
from daq.speed.options import SpeedMethod, SpeedOptions

T = 4e-4
NOISE_RAD = 3.0 * 20.0 * np.pi / 65536.0
METHODS = pytest.mark.parametrize("method", list(SPEED_METHODS))

FloatArray = npt.NDArray[np.float64]


def noisy_sine(seconds: float, seed: int) -> tuple[FloatArray, FloatArray]:
    """Position with the potentiometer's noise and true speed of 1 rad/s at 0.2 Hz."""
    time_s = np.arange(0.0, seconds, T)
    omega = 2.0 * np.pi * 0.2
    noise = np.random.default_rng(seed).normal(scale=NOISE_RAD, size=len(time_s))
    return 20.0 - np.cos(omega * time_s) / omega + noise, np.sin(omega * time_s)


@METHODS
@pytest.mark.parametrize("n", [2, 3, 10, 400, 5000])
def test_steady_motion_gives_its_speed_everywhere(method: SpeedMethod, n: int) -> None:
    position = 5.0 + 3.0 * T * np.arange(n, dtype=np.float64)
    speed = speed_from_position_zero_phase(position, T, SpeedOptions(method=method))
    # The Kalman smoother starts from a wide but finite prior: two samples leave 3e-3 of it.
    assert np.allclose(speed, 3.0, rtol=3e-3)


@METHODS
def test_single_sample_has_no_speed(method: SpeedMethod) -> None:
    assert speed_from_position_zero_phase(np.array([7.0]), T, SpeedOptions(method=method)).tolist() == [0.0]


@METHODS
def test_error_is_the_computed_noise(method: SpeedMethod) -> None:
    options = SpeedOptions(method=method)
    position, truth = noisy_sine(40.0, seed=3)
    error = (speed_from_position_zero_phase(position, T, options) - truth)[2500:-2500]
    expected = describe_zero_phase(T, options).noise_gain_per_s * NOISE_RAD
    # The error's correlation time is some 20 ms, so 36 s hold about 1800 independent values: 2 % of scatter.
    assert np.sqrt(np.mean(error**2)) == pytest.approx(expected, rel=0.1)


@METHODS
@pytest.mark.parametrize(
    ("sample_time_s", "bandwidth_hz"), [(4e-4, 2.0), (4e-4, 40.0), (1e-3, 10.0), (0.01, 5.0)]
)
def test_bandwidth_is_the_one_asked_for(
    method: SpeedMethod, sample_time_s: float, bandwidth_hz: float
) -> None:
    spec = describe_zero_phase(sample_time_s, SpeedOptions(method=method, bandwidth_hz=bandwidth_hz))
    # Savitzky-Golay windows are whole numbers of samples: 25 of them at the coarsest here, in steps of 2.
    assert spec.bandwidth_hz == pytest.approx(bandwidth_hz, rel=0.05)
    assert spec.delay_s == 0.0
    assert spec.delay_half_band_s == 0.0


@METHODS
def test_stated_bandwidth_is_what_a_sine_meets(method: SpeedMethod) -> None:
    options = SpeedOptions(method=method)
    omega = 2.0 * np.pi * describe_zero_phase(T, options).bandwidth_hz
    time_s = np.arange(0.0, 4.0, T)
    speed = speed_from_position_zero_phase(np.sin(omega * time_s), T, options)[2500:-2500]
    assert np.sqrt(2.0 * np.mean(speed**2)) / omega == pytest.approx(np.sqrt(0.5), rel=1e-2)


@METHODS
def test_causal_filter_lags_by_the_stated_delay(method: SpeedMethod) -> None:
    speed_filter = CausalSpeedFilter(T, SpeedOptions(method=method))
    omega = 2.0 * np.pi * 0.05  # far below the bandwidth
    time_s = np.arange(0.0, 20.0, T)
    speed = speed_filter.step(speed_filter.init(), np.sin(omega * time_s) / omega)[5000:]
    expected = np.cos(omega * (time_s[5000:] - speed_filter.spec.delay_s))
    assert np.abs(speed - expected).max() < 1e-3


@METHODS
def test_causal_numbers_do_not_depend_on_the_size_of_blocks(method: SpeedMethod) -> None:
    position, _ = noisy_sine(2.0, seed=4)
    speed_filter = CausalSpeedFilter(T, SpeedOptions(method=method))
    whole = speed_filter.step(speed_filter.init(), position)
    state = speed_filter.init()
    cuts = np.cumsum(np.random.default_rng(5).integers(0, 60, size=400))
    pieces = [speed_filter.step(state, piece) for piece in np.split(position, cuts[cuts < len(position)])]
    assert np.array_equal(np.concatenate(pieces), whole)


@METHODS
def test_causal_filter_at_rest_reports_zero_from_the_first_sample(method: SpeedMethod) -> None:
    speed_filter = CausalSpeedFilter(T, SpeedOptions(method=method))
    speed = speed_filter.step(speed_filter.init(), np.full(1000, 25.0))
    # 25 rad of offset against 1e-9 rad/s: what is left is rounding.
    assert np.abs(speed).max() < 1e-9


@METHODS
def test_causal_filter_knows_nothing_of_the_future(method: SpeedMethod) -> None:
    position, _ = noisy_sine(1.0, seed=6)
    other = position.copy()
    other[1500:] += 1.0
    speed_filter = CausalSpeedFilter(T, SpeedOptions(method=method))
    one, two = (speed_filter.step(speed_filter.init(), each) for each in (position, other))
    assert np.array_equal(one[:1500], two[:1500])


@METHODS
def test_input_is_not_modified(method: SpeedMethod) -> None:
    position, _ = noisy_sine(1.0, seed=7)
    before = position.copy()
    speed_from_position_zero_phase(position, T, SpeedOptions(method=method))
    assert np.array_equal(position, before)


def test_kalman_smoother_is_the_least_squares_solution_of_its_model() -> None:
    # The smoother must minimise the squared noise and the squared jerk, each over its covariance: solve that.
    n, bandwidth_hz = 40, 100.0
    position = np.random.default_rng(8).normal(size=n).cumsum() * 0.01
    w0 = 2.0 * np.pi * bandwidth_hz * T / (np.sqrt(2.0) - 1.0) ** (1.0 / 6.0)
    transition = np.array([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
    process = w0**6 * np.array([[1 / 20, 1 / 8, 1 / 6], [1 / 8, 1 / 3, 1 / 2], [1 / 6, 1 / 2, 1.0]])
    prior = 1e6 * np.diag([1.0, w0**2, w0**4])
    information = np.zeros((3 * n, 3 * n))
    information[:3, :3] += np.linalg.inv(prior)
    for k in range(n - 1):
        step = np.zeros((3, 3 * n))
        step[:, 3 * k : 3 * k + 3], step[:, 3 * k + 3 : 3 * k + 6] = -transition, np.eye(3)
        information += step.T @ np.linalg.inv(process) @ step
    information[::3, ::3] += np.eye(n)
    right = np.zeros(3 * n)
    right[::3] = position
    right[:3] += np.linalg.inv(prior) @ np.array([position[0], 0.0, 0.0])
    expected = np.linalg.solve(information, right)[1::3] / T
    # The information matrix has a condition number of about 1e9, which leaves seven digits.
    assert np.allclose(KalmanSpeed(T, bandwidth_hz).zero_phase(position), expected, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("bandwidth_hz", [0.1, 300.0, float("nan")])
def test_impossible_bandwidth_is_refused_with_the_range(bandwidth_hz: float) -> None:
    with pytest.raises(ValueError, match=r"must lie between 0\.5 and 250 Hz at a sample time of 0\.0004 s"):
        CausalSpeedFilter(T, SpeedOptions(bandwidth_hz=bandwidth_hz))


def test_position_that_is_not_finite_is_refused_with_its_row() -> None:
    position = np.zeros(10)
    position[4] = np.nan
    with pytest.raises(ValueError, match="position at row 4 is nan"):
        speed_from_position_zero_phase(position, T)
