"""The mean over the time ahead, on which the input of a decimated recording rests."""

import numpy as np
import pytest

from daq.recording.kernels import average_ahead


@pytest.mark.parametrize("span_s", [0.004, 0.0213, 10.0], ids=["below a step", "some steps", "all"])
def test_mean_is_the_integral_of_straight_lines_over_the_span(span_s: float) -> None:
    rng = np.random.default_rng(3)
    time_s = np.cumsum(rng.uniform(0.005, 0.015, size=200))
    values = rng.normal(size=200)
    means = np.full(200, np.nan)
    average_ahead(time_s, values, span_s, means)
    areas = np.diff(time_s) * (values[1:] + values[:-1]) / 2
    integral = np.concatenate([[0.0], np.cumsum(areas)])
    ends_s = np.minimum(time_s + span_s, time_s[-1])[:-1]
    expected = (np.interp(ends_s, time_s, integral) - integral[:-1]) / (ends_s - time_s[:-1])
    np.testing.assert_allclose(means[:-1], expected, rtol=1e-9, atol=1e-12)
    assert means[-1] == values[-1]


def test_constant_and_single_samples_stay_as_they_are() -> None:
    means = np.empty(5)
    average_ahead(np.linspace(0.0, 0.4, 5), np.full(5, 2.5), 0.2, means)
    np.testing.assert_allclose(means, 2.5, rtol=1e-14)
    one = np.empty(1)
    average_ahead(np.zeros(1), np.array([7.0]), 0.2, one)
    assert one[0] == 7.0
