"""The clock fit against ticks whose rate is known."""

import numpy as np
import pytest

from daq.clock.fit import ClockFitOptions, ClockFitState, ClockFitter, PingSample

RATE_HZ = 2500.0 * (1 + 50e-6)
START_NS = 10**15


def ping_at(
    t_s: float, round_trip_s: float, *, rate_hz: float = RATE_HZ, tick0: float = 1000.0
) -> PingSample:
    """Return a ping whose tick was read in the middle of its round trip."""
    exact = tick0 + rate_hz * t_s
    tick = int(np.floor(exact))
    half_ns = round(round_trip_s * 5e8)
    middle_ns = START_NS + round(t_s * 1e9)
    return PingSample(
        t_sent_ns=middle_ns - half_ns,
        t_received_ns=middle_ns + half_ns,
        tick=tick % (1 << 32),
        subtick=int((exact - tick) * 65536),
    )


def fed(pings: list[PingSample]) -> ClockFitState:
    """Return the state after `pings`."""
    fitter = ClockFitter(ClockFitOptions())
    state = fitter.init()
    for ping in pings:
        fitter.step(state, ping)
    return state


def test_exact_pings_give_rate_and_offset() -> None:
    fit = fed([ping_at(t, 1e-3) for t in range(60)]).fit
    assert fit is not None
    # A subtick is 1/65536 of 400 us = 6 ns; over a minute that is far below 1e-3 ppm.
    assert fit.rate_error_ppm == pytest.approx(50.0, abs=1e-3)
    assert fit.residual_s < 10e-9
    assert fit.tick_at(START_NS) == pytest.approx(1000.0, abs=1e-3)
    assert fit.t_ns_at(1000.0) == pytest.approx(START_NS, abs=1000)


def test_slow_round_trips_do_not_spoil_the_line() -> None:
    rng = np.random.default_rng(7)
    pings = []
    for t in range(200):
        delay_s = 0.0 if t % 2 else float(rng.uniform(0.002, 0.02))
        quick = ping_at(t, 1e-3)
        # All of the delay lies after the tick was read: the midpoint is late by half of it.
        late_ns = round(delay_s * 1e9)
        pings.append(
            PingSample(
                t_sent_ns=quick.t_sent_ns, t_received_ns=quick.t_received_ns + late_ns,
                tick=quick.tick, subtick=quick.subtick,
            )
        )  # fmt: skip
    fit = fed(pings).fit
    assert fit is not None
    assert fit.rate_error_ppm == pytest.approx(50.0, abs=0.01)
    assert fit.min_round_trip_s == pytest.approx(1e-3)


def test_one_impossible_ping_is_counted_and_left_out() -> None:
    pings = [ping_at(t, 1e-3) for t in range(10)]
    pings.append(ping_at(10, 1e-3, tick0=5000.0))
    pings.extend(ping_at(t, 1e-3) for t in range(11, 15))
    fit = fed(pings).fit
    assert fit is not None
    assert (fit.pings_rejected, fit.jumps) == (1, 0)
    assert fit.rate_error_ppm == pytest.approx(50.0, abs=0.1)


def test_jump_of_the_counter_starts_a_new_line() -> None:
    pings = [ping_at(t, 1e-3) for t in range(10)]
    pings.extend(ping_at(t, 1e-3, tick0=9000.0) for t in range(10, 20))
    fit = fed(pings).fit
    assert fit is not None
    assert fit.jumps == 1
    assert fit.tick_at(START_NS) == pytest.approx(9000.0, abs=0.01)


def test_counter_that_does_not_follow_the_host_clock_is_no_trouble() -> None:
    rng = np.random.default_rng(3)
    ticks = np.cumsum(
        rng.uniform(2_500, 400_000, 40)
    )  # an emulated controller at full speed, now and then idle
    state = fed([ping_at(t, 1e-3, tick0=ticks[t] - RATE_HZ * t) for t in range(40)])
    assert state.fit is not None
    assert (state.fit.steady, state.fit.jumps) == (False, 0)
    assert state.fit.pings_rejected <= 2 * ClockFitOptions().jump_after
    newest_s = START_NS + 39 * 10**9
    assert state.fit.tick_at(newest_s) == pytest.approx(ticks[39], abs=400_000)


def test_two_late_answers_at_the_start_are_no_jump() -> None:
    # The first two answers came 4 ms late and early: the line through them misses the tenth ping by 80 ms.
    pings = [ping_at(0, 1e-3, tick0=1010.0), ping_at(1, 1e-3, tick0=990.0)]
    fit = fed(pings + [ping_at(t, 1e-3) for t in range(2, 12)]).fit
    assert fit is not None
    assert (fit.jumps, fit.steady) == (0, True)


def test_line_goes_on_when_the_counter_wraps() -> None:
    near_wrap = float((1 << 32) - 10_000)
    fit = fed([ping_at(t, 1e-3, tick0=near_wrap) for t in range(30)]).fit
    assert fit is not None
    assert fit.jumps == 0
    assert fit.rate_error_ppm == pytest.approx(50.0, abs=0.01)


def test_single_ping_uses_the_announced_rate() -> None:
    fit = fed([ping_at(0, 1e-3)]).fit
    assert fit is not None
    assert fit.rate_hz == 2500.0
