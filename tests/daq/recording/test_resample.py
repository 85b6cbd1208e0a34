"""Decimation keeps what is below the new Nyquist frequency, nothing above it, and delays nothing."""

import numpy as np
import pytest

from daq.recording.recording import GapSpan, recording_from_columns
from daq.recording.resample import (
    PASS_BAND,
    decimate,
    decimate_recording,
    design_antialias,
    frequency_response,
)

FACTORS = pytest.mark.parametrize("factor", [2, 3, 5, 10, 25, 500])


@FACTORS
def test_stop_band_begins_at_the_new_nyquist_frequency_with_60_db(factor: int) -> None:
    stop = np.linspace(0.5 / factor, min(0.5, 3.0 / factor), 800)
    assert np.abs(frequency_response(design_antialias(factor), stop)).max() < 1e-3


@FACTORS
def test_pass_band_is_flat_to_a_hundredth_of_a_decibel(factor: int) -> None:
    passed = np.linspace(0.0, PASS_BAND * 0.5 / factor, 200)
    gain_db = 20.0 * np.log10(frequency_response(design_antialias(factor), passed))
    assert np.abs(gain_db).max() < 0.01


@FACTORS
@pytest.mark.parametrize("extra", [0, 1])
def test_straight_line_is_kept_to_its_ends(factor: int, extra: int) -> None:
    values = 3.0 + 0.01 * np.arange(40 * factor + extra, dtype=np.float64)
    # Rounding of sums over up to 14,000 taps.
    assert np.allclose(decimate(values, factor), values[::factor], atol=1e-9)


def test_sine_below_passes_without_delay_and_one_above_vanishes() -> None:
    k = np.arange(20000)
    slow, fast = np.sin(2 * np.pi * 0.002 * k), np.sin(2 * np.pi * 0.06 * k)
    kept = decimate(slow + fast, 10)
    # Away from the ends only the stop band's 1e-3 is left of the fast one.
    assert np.abs(kept - slow[::10])[40:-40].max() < 1.5e-3


def test_ends_are_as_good_as_the_fitted_end_point() -> None:
    rng = np.random.default_rng(1)
    k = np.arange(-6000, 26000)
    values = np.sin(2 * np.pi * k / 5000.0) + rng.normal(scale=0.01, size=len(k))
    whole = decimate(values, 100)[60:260]
    part = decimate(values[6000:26000], 100)
    # The noise is reduced tenfold inside and threefold at the end itself.
    assert np.abs(part - whole).max() < 0.01


@pytest.mark.parametrize("n", [1, 2, 7, 30])
def test_short_runs_give_finite_values_near_the_data(n: int) -> None:
    values = np.linspace(1.0, 2.0, n)
    kept = decimate(values, 10)
    assert len(kept) == -(-n // 10)
    assert np.allclose(kept, values[::10], atol=0.2)


def test_factor_below_one_is_refused() -> None:
    with pytest.raises(ValueError, match="decimation factor 0 must be at least 1"):
        decimate(np.ones(5), 0)


def test_recording_is_decimated_run_by_run_and_keeps_its_hole() -> None:
    time_s = np.concatenate([np.arange(100), np.arange(150, 205)]) * 0.01
    gap = GapSpan(row=100, start_s=1.0, missing_samples=50, cause="loss")
    current = np.concatenate([np.full(100, 1.0), np.full(55, -1.0)])
    recording = recording_from_columns(
        {"time_s": time_s, "current_A": current}, sample_time_s=0.01, gaps=(gap,)
    )
    kept = decimate_recording(recording, 10)
    assert kept.sample_time_s == pytest.approx(0.1)
    assert np.allclose(kept.time_s, np.concatenate([np.arange(10), np.arange(15, 21)]) * 0.1)
    assert np.allclose(kept.column("current_A"), np.repeat([1.0, -1.0], [10, 6]))
    assert [(span.row, span.missing_samples) for span in kept.gaps] == [(10, 5)]
    assert kept.metadata["decimation"]["stop_band_hz"] == pytest.approx(5.0)


def test_hole_at_the_end_stays_at_the_end() -> None:
    gap = GapSpan(row=20, start_s=0.2, missing_samples=3, cause="loss")
    columns = {"time_s": np.arange(20) * 0.01, "current_A": np.zeros(20)}
    kept = decimate_recording(recording_from_columns(columns, sample_time_s=0.01, gaps=(gap,)), 5)
    assert [span.row for span in kept.gaps] == [4]
    assert kept.segments() == (slice(0, 4),)
    assert not kept.gap.any()
