"""Waveforms against values worked out by hand from docs/protocol.md, "Generators"."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from daq.excitation.spec import (
    Chirp,
    Excitation,
    Multisine,
    Prbs,
    Setpoints,
    Sine,
    Staircase,
    Table,
    Trapezoid,
)
from daq.excitation.waveform import run_length, sample_reference
from daq.protocol.codes import ChirpMode, StaircaseMode

TICK_HZ = 2500
TICK_S = 1 / TICK_HZ


def levels(excitation: Excitation | Setpoints, *ticks: int) -> list[float]:
    """Return the reference at single ticks."""
    return [float(sample_reference(excitation, np.array([k]), TICK_HZ)[0]) for k in ticks]


def test_sine_passes_its_quarter_points() -> None:
    sine = Sine(amplitude_a=0.5, offset_a=0.1, period_s=4.0, duration_s=100.0)
    assert_allclose(levels(sine, 0, 2500, 5000, 7500), [0.1, 0.6, 0.1, -0.4], atol=1e-12)


def test_sine_started_at_its_peak() -> None:
    assert_allclose(levels(Sine(amplitude_a=1.0, period_s=4.0, duration_s=9.0, phase_turns=0.25), 0), [1.0])


def test_trapezoid_rises_within_its_fraction() -> None:
    # rise_fraction 0.5 of 8 s takes 4 s from -1 to +1: from 0 to 1 in the first 2 s, a triangle.
    triangle = Trapezoid(amplitude_a=1.0, period_s=8.0, rise_fraction=0.5, duration_s=80.0)
    assert_allclose(levels(triangle, 0, 2500, 5000, 10000, 15000), [0.0, 0.5, 1.0, 0.0, -1.0], atol=1e-12)
    steep = Trapezoid(amplitude_a=1.0, period_s=8.0, rise_fraction=0.125, duration_s=80.0)
    assert_allclose(levels(steep, 625, 1250, 5000, 8750, 10625), [0.5, 1.0, 1.0, 1.0, -0.5], atol=1e-12)


@pytest.mark.parametrize(
    ("mode", "turns_at_half"),
    [(ChirpMode.LINEAR, 1.0 * 5 + 3.0 * 25 / 20), (ChirpMode.LOGARITHMIC, 10 / np.log(4.0) * (2.0 - 1.0))],
)
def test_chirp_has_turned_so_far_at_half_time(mode: ChirpMode, turns_at_half: float) -> None:
    chirp = Chirp(amplitude_a=1.0, sweep_s=10.0, start_hz=1.0, end_hz=4.0, mode=mode)
    assert_allclose(levels(chirp, 12_500), [np.sin(2 * np.pi * turns_at_half)], atol=1e-9)


def test_prbs_follows_its_polynomial() -> None:
    # x^5 + x^3 + 1 from state 00001, worked out by hand: the top bit of each state.
    prbs = Prbs(amplitude_a=0.3, register_bits=5, bit_s=TICK_S, duration_s=1.0, seed=1)
    bits = (sample_reference(prbs, np.arange(62), TICK_HZ) > 0).astype(int)
    assert "".join(map(str, bits[:12])) == "000010010110"
    assert list(bits[:31]) == list(bits[31:])
    assert bits[:31].sum() == 16


def test_staircase_orders_its_levels() -> None:
    hold = 10 * TICK_S
    middles = np.arange(8) * 10 + 5
    up_down = Staircase(amplitude_a=1.0, levels=3, level_s=hold, mode=StaircaseMode.UP_DOWN)
    from_zero = Staircase(amplitude_a=1.0, levels=5, level_s=hold, mode=StaircaseMode.FROM_ZERO)
    up = Staircase(amplitude_a=1.0, levels=3, level_s=hold, mode=StaircaseMode.UP)
    assert_allclose(sample_reference(up, middles, TICK_HZ), [-1, 0, 1, 0, 0, 0, 0, 0])
    assert_allclose(sample_reference(up_down, middles, TICK_HZ), [-1, 0, 1, 0, 0, 0, 0, 0])
    assert_allclose(sample_reference(from_zero, middles, TICK_HZ), [0, 0.5, 1, 0.5, 0, -0.5, -1, -0.5])


def test_multisine_of_one_line_has_the_documented_phase() -> None:
    line = Multisine(amplitude_a=1.0, period_s=1.0, lines=1, seed=1, duration_s=2.0)
    phase = 270369 / 2**32  # first xorshift32 value of seed 1, printed in the document
    ticks = np.array([0, 100, 625, 2000])
    expected = np.sin(2 * np.pi * (ticks / 2500 + phase))
    # The peak is looked for on a grid of 8192 points: at most 1 - cos(pi / 8192) = 7e-8 too low.
    assert_allclose(sample_reference(line, ticks, TICK_HZ), expected, atol=1e-6)


def test_multisine_peaks_at_its_amplitude() -> None:
    wave = sample_reference(
        Multisine(amplitude_a=0.7, period_s=8.0, lines=10, step=2, seed=42, duration_s=8.0),
        np.arange(20_000),
        TICK_HZ,
    )
    assert np.abs(wave).max() == pytest.approx(0.7, rel=0.01)


def test_table_is_played_in_whole_counts() -> None:
    table = Table(values_a=(0.5, -0.25, 1e-5), hold_s=2 * TICK_S, repeat=True, duration_s=1.0)
    assert_allclose(levels(table, 0, 1, 2, 4, 6), [0.5, 0.5, -0.25, 0.0, 0.5])


def test_set_points_are_held_and_end() -> None:
    points = Setpoints(values_a=(0.5, -0.25), hold_s=2 * TICK_S)
    assert_allclose(sample_reference(points, np.arange(-1, 6), TICK_HZ), [0, 0.5, 0.5, -0.25, -0.25, 0, 0])


def test_fade_covers_offset_and_both_ends() -> None:
    ramp = Prbs(
        amplitude_a=0.0, offset_a=1.0, register_bits=5, bit_s=1.0, duration_s=10 * TICK_S, ramp_s=4 * TICK_S
    )
    expected = [0, 0, 0.25, 0.5, 0.75, 1, 1, 1, 0.75, 0.5, 0.25, 0]
    assert_allclose(sample_reference(ramp, np.arange(-1, 11), TICK_HZ), expected)


@pytest.mark.parametrize(
    ("excitation", "ticks"),
    [
        (Sine(amplitude_a=0.1, period_s=1.0), None),
        (Chirp(amplitude_a=0.1, sweep_s=2.0, start_hz=1.0, end_hz=2.0), 5000),
        (Chirp(amplitude_a=0.1, sweep_s=2.0, start_hz=1.0, end_hz=2.0, repeat=True), None),
        (Staircase(amplitude_a=0.1, levels=5, level_s=1.0, duration_s=2.0), 5000),
        (Staircase(amplitude_a=0.1, levels=5, level_s=1.0), 8 * 2500),
        (Table(values_a=(0.1, 0.2), hold_s=1.0), 5000),
    ],
)
def test_run_ends_with_duration_or_by_itself(excitation: Excitation, ticks: int | None) -> None:
    assert run_length(excitation, TICK_HZ) == ticks


@pytest.mark.parametrize(
    ("excitation", "message"),
    [
        (Sine(amplitude_a=0.1, period_s=1e-4), r"period_s=0.0001 must lie in \[0.0016"),
        (Sine(amplitude_a=float("nan"), period_s=1.0), "amplitude_a=nan must lie in"),
        (
            Trapezoid(amplitude_a=0.1, period_s=1.0, rise_fraction=0.7),
            r"rise_fraction=0.7 must lie in .*0.5\]",
        ),
        (Chirp(amplitude_a=0.1, sweep_s=1.0, start_hz=1.0, end_hz=900.0), r"end_hz=900 must lie in .*625\]"),
        (Prbs(amplitude_a=0.1, register_bits=8, bit_s=0.1), "register_bits=8 has no polynomial"),
        (Prbs(amplitude_a=0.1, register_bits=5, bit_s=0.1, seed=32), "seed=32 must be"),
        (Staircase(amplitude_a=0.1, levels=4, level_s=1.0), "levels=4 must be odd"),
        (Multisine(amplitude_a=0.1, period_s=0.01, lines=10), "highest harmonic 10 exceeds 6"),
        (Table(values_a=(0.0,) * 1025, hold_s=0.1), "number of values_a=1025"),
        (Sine(amplitude_a=0.1, period_s=1.0, ramp_s=30.0), "ramp_s=30 must lie in"),
    ],
)
def test_value_that_no_generator_can_play_is_named(excitation: Excitation, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        excitation.to_run_command(TICK_HZ)


def test_set_point_beyond_a_word_is_named() -> None:
    with pytest.raises(ValueError, match=r"values_a\[1\]=4\.5 A"):
        sample_reference(Setpoints(values_a=(0.0, 4.5), hold_s=0.1), np.arange(3), TICK_HZ)
