"""What the making of the records leaves open: smoothing of a derived speed, repeats, the instant a current is read."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from discrepancy.data.repeats import find_repeats, merge_repeats
from discrepancy.data.series import SPEED, Channel, Series
from discrepancy.search.context import Context
from discrepancy.search.options import SearchOptions
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.joint import simulate_record
from discrepancy.simulation.kernels.smoothing import smooth_speed

STEP = 0.005


def series(current: np.ndarray, speed: np.ndarray, angle: np.ndarray | None = None) -> Series:
    n = current.size
    time = np.arange(n, dtype=np.float64) * STEP
    return Series(
        label="r", step=STEP, original_step=STEP, time_s=time, input=current,
        angle=np.cumsum(speed) * STEP if angle is None else angle,
        channels=(Channel(name="speed_rad_s", row=SPEED, values=speed, weight=np.ones(n)),),
        windows=np.array([-1], dtype=np.int64), starts=np.zeros((1, 2)),
    )  # fmt: skip


@pytest.mark.parametrize("order", [2, 3])
def test_smoothing_is_a_butterworth_filter_run_both_ways(order: int) -> None:
    speed = np.random.default_rng(1).normal(size=4000)
    corner_hz = 10.0
    wanted = sosfiltfilt(butter(order, corner_hz, fs=1.0 / STEP, output="sos"), speed)
    found = speed.copy()
    smooth_speed(found, np.array([-1], dtype=np.int64), STEP, 1.0 / (2.0 * np.pi * corner_hz), float(order))
    inside = slice(200, -200)
    assert found[inside] == pytest.approx(wanted[inside], abs=1e-9)


def test_smoothing_does_not_reach_across_a_hole() -> None:
    speed = np.concatenate([np.zeros(500), np.ones(500)])
    smooth_speed(speed, np.array([-1, -501], dtype=np.int64), STEP, 0.02, 2.0)
    assert speed == pytest.approx(np.concatenate([np.zeros(500), np.ones(500)]), abs=1e-12)


@pytest.mark.parametrize("extra", [{}, {s.CURRENT_LIMIT: 100.0}])
def test_the_current_is_read_at_the_sample_by_both_kernels(extra: dict[int, float]) -> None:
    # A limit that is never reached sends the record through the whole kernel instead of the plain one.
    vector = s.neutral_vector()
    vector[s.VISCOUS], vector[s.INPUT_SHIFT], vector[s.MAX_STEP] = 1.0, 0.003, 0.002
    for slot, value in extra.items():
        vector[slot] = value
    time = np.arange(400, dtype=np.float64) * STEP
    current = np.sin(2.0 * np.pi * time)
    windows, starts = np.array([-1], dtype=np.int64), np.zeros((1, 2))
    out = simulate_record(vector, time, current, np.empty(0), windows, starts)
    wanted = np.interp(time - 0.003, time, current)
    assert out[2, 1:] == pytest.approx(wanted[1:], abs=1e-12)


def test_periods_of_one_record_are_repeats_but_the_first() -> None:
    current = np.tile(np.random.default_rng(2).normal(size=400), 5)
    pairs = find_repeats([series(current, current)])
    assert [(pair.a, pair.b, pair.n) for pair in pairs] == [
        (400, 800, 400),
        (800, 1200, 400),
        (1200, 1600, 400),
    ]


def test_an_input_without_a_period_has_no_repeats() -> None:
    current = np.random.default_rng(3).normal(size=2000)
    assert find_repeats([series(current, current)]) == []


def test_repeats_are_averaged_and_count_twice() -> None:
    rng = np.random.default_rng(4)
    current = rng.normal(size=2000)
    angle = np.linspace(0.0, 3.0, 2000)
    two = [series(current, current + 0.01 * rng.normal(size=2000), angle) for _ in range(2)]
    [mean] = merge_repeats(two, find_repeats(two))
    assert mean.channels[0].weight == pytest.approx(np.full(2000, np.sqrt(2.0)))
    apart = 0.5 * (two[0].channels[0].values + two[1].channels[0].values)
    assert mean.channels[0].values == pytest.approx(apart)


def test_repeats_that_stood_elsewhere_or_diverged_are_kept_apart() -> None:
    rng = np.random.default_rng(5)
    current, angle = rng.normal(size=2000), np.linspace(0.0, 3.0, 2000)
    first = series(current, current + 0.01 * rng.normal(size=2000), angle)
    moved = replace(first, angle=angle + 0.1)
    assert len(merge_repeats([first, moved], find_repeats([first, moved]))) == 2
    values = first.channels[0].values + 0.01 * rng.normal(size=2000)
    values[1000:1100] += rng.normal(size=100)
    diverged = replace(first, channels=(replace(first.channels[0], values=values),))
    assert len(merge_repeats([first, diverged], find_repeats([first, diverged]))) == 2


def test_noise_that_no_repeat_shows_asks_for_more_evidence() -> None:
    from discrepancy.fitting.problem import Noise, SimulationProblem

    noise = Noise(sigma={"speed_rad_s": 1.0})
    scout = SimulationProblem(series=(series(np.zeros(10), np.zeros(10)),), noise=noise)
    options = SearchOptions()
    seen = Context(executor=None, repeat_noise=noise, bin_size=np.ones(1), scout=scout)
    assert seen.alarm(options) == options.alarm
    assert replace(seen, repeat_noise=None).alarm(options) == options.unsure * options.alarm


@pytest.mark.parametrize(("noise", "repeats"), [(0.0, 0), (0.03, 1)])
def test_repeats_that_only_coarse_rounding_makes_alike_show_no_noise(noise: float, repeats: int) -> None:
    rng = np.random.default_rng(8)
    current = np.cumsum(rng.normal(size=4000)) / 30.0
    speed = np.convolve(current, np.ones(50) / 50.0, mode="same")
    both = [
        series(current, np.round((speed + noise * rng.normal(size=4000)) / 0.05) * 0.05) for _ in range(2)
    ]
    assert len(find_repeats(both)) == repeats
