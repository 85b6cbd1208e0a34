"""Data sets with holes, and the regressors built from them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from estimators.dataset import Dataset, split_at_holes
from estimators.regressors import build_regression
from estimators.settings import IdentifyOptions
from estimators.structure import ModelStructure


def make_ramp(n: int, starts: tuple[int, ...] = (0,)) -> Dataset:
    return Dataset(u=np.arange(100.0, 100.0 + n), y=np.arange(float(n)), sample_time_s=0.1, starts=starts)


def test_regressor_holds_the_paper_s_terms_in_its_order() -> None:
    rows = build_regression(make_ramp(10), ModelStructure(na=2, nb=2))
    # Eq. 5 at k = 2: [-y(1), -y(0), u(1), u(0)].
    np.testing.assert_array_equal(rows.phi[0], [-1.0, 0.0, 101.0, 100.0])
    assert (rows.rows[0], rows.y[0]) == (2, 2.0)


def test_delay_moves_the_input_terms_only() -> None:
    rows = build_regression(make_ramp(12), ModelStructure(na=1, nb=2, delay=3))
    np.testing.assert_array_equal(rows.phi[0], [-3.0, 101.0, 100.0])
    assert rows.rows[0] == 4


def test_no_regressor_reaches_across_a_hole() -> None:
    rows = build_regression(make_ramp(20, starts=(0, 9)), ModelStructure(na=2, nb=2))
    assert rows.rows.tolist() == [*range(2, 9), *range(11, 20)]
    assert rows.bounds == (slice(0, 7), slice(7, 16))
    np.testing.assert_array_equal(rows.phi[7], [-10.0, -9.0, 110.0, 109.0])


def test_a_segment_too_short_for_one_regressor_is_left_out() -> None:
    rows = build_regression(make_ramp(20, starts=(0, 10, 12)), ModelStructure(na=2, nb=2))
    assert rows.rows.tolist() == [*range(2, 10), *range(14, 20)]


def test_too_few_samples_are_refused_with_the_numbers() -> None:
    with pytest.raises(ValueError, match="6 samples in 1 segments give 4 regressors for 4 parameters"):
        build_regression(make_ramp(6), ModelStructure(na=2, nb=2))


def test_a_taken_part_keeps_the_holes_inside_it() -> None:
    part = make_ramp(20, starts=(0, 5, 9, 15)).take(7, 16)
    assert part.starts == (0, 2, 8)
    assert part.n == 9


def test_split_at_holes_drops_the_hole_and_starts_a_segment() -> None:
    y = np.array([0.0, 1.0, np.nan, 3.0, 4.0, np.inf, np.nan, 7.0])
    record = split_at_holes(np.arange(8.0), y, 0.1)
    assert record.starts == (0, 2, 4)
    np.testing.assert_array_equal(record.u, [0.0, 1.0, 3.0, 4.0, 7.0])


def test_split_at_holes_keeps_known_starts_even_inside_a_hole() -> None:
    y = np.array([0.0, 1.0, 2.0, np.nan, 4.0, 5.0])
    assert split_at_holes(np.zeros(6), y, 0.1, starts=(0, 1, 3)).starts == (0, 1, 3)


@given(st.lists(st.one_of(st.floats(-1e3, 1e3), st.just(float("nan"))), min_size=1, max_size=40))
def test_neighbours_in_a_segment_were_neighbours_in_the_record(values: list[float]) -> None:
    y = np.array(values)
    if not np.any(np.isfinite(y)):
        return
    record = split_at_holes(np.arange(float(y.size)), y, 0.1)
    for segment in record.segments:
        assert np.all(np.diff(record.u[segment]) == 1.0)
    inner = [record.u[start] - record.u[start - 1] for start in record.starts[1:]]
    assert all(step > 1.0 for step in inner)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"y": [0.0, float("nan"), 1.0]}, r"y\[1\]=nan is not finite \(1 of 3 samples\); use split_at_holes"),
        ({"u": [1.0, 2.0]}, "u has 2 samples and y has 3"),
        ({"u": [[1.0, 2.0, 3.0]]}, r"u has shape \(1, 3\)"),
        ({"sample_time_s": 0.0}, "sample_time_s=0.0 must be a positive number of seconds"),
        ({"starts": (0, 3)}, r"starts=\(0, 3\) must begin with 0, increase, and stay below 3 samples"),
        ({"starts": (1,)}, "must begin with 0"),
    ],
)
def test_unusable_data_are_refused_with_the_value(changes: dict[str, object], text: str) -> None:
    fields: dict[str, object] = {"u": [1.0, 2.0, 3.0], "y": [1.0, 2.0, 3.0], "sample_time_s": 0.1, **changes}
    with pytest.raises(ValueError, match=text):
        Dataset(**fields)  # type: ignore[arg-type]  # wrong values are the point of this test


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"order": 0}, r"na=0 must lie in \[1, 50\]"),
        ({"delay": 0}, r"delay=0 must lie in \[1, 50\]"),
        ({"methods": ()}, "methods is empty"),
        ({"methods": ("rls", "rls")}, "methods=rls,rls names an estimator twice"),
        ({"residual_terms": 0}, r"residual_terms=0 must lie in \[1, 10\]"),
        ({"max_lag": 0}, r"max_lag=0 must lie in \[1, 500\]"),
    ],
)
def test_options_out_of_range_are_refused(changes: dict[str, object], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        IdentifyOptions(**changes)  # type: ignore[arg-type]  # wrong values are the point of this test
