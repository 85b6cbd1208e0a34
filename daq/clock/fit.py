"""Fit of the controller's tick counter to the host's monotonic clock, from PING round trips.

Theory of operation. A PING leaves the host at `t_sent_ns`, the controller answers with its tick (and a fraction of
a tick), the answer arrives at `t_received_ns`. The tick was read somewhere in between, so the midpoint is wrong by
at most half the round trip. Quick round trips therefore say more than slow ones: the straight line
tick = rate * (t - t0) + tick0 is fitted by least squares through the quickest of the last pings only.
For the same reason a ping that lies further off the line than half its own round trip cannot be explained by
transport (nor by the line itself, which is the less certain the further it reaches beyond its points): one alone is
counted as an outlier; several in a row that run at the announced rate mean that the tick counter jumped, and the fit
starts anew from them. Several that do not run at it mean a counter that does not follow the host's clock, as that
of an emulated controller at full speed: from then on the line goes through the newest pings and claims nothing else.
Crystals differ by some 50 ppm, which is 180 ms per hour: the rate is measured, never assumed.

This file reads no clock; times come in with the pings.
"""

from collections import deque
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_WRAP = 1 << 32
_NS = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class PingSample:
    """One PING round trip.

    Attributes:
        t_sent_ns: Host monotonic time when the command was handed to the port.
        t_received_ns: Host monotonic time when the reply had arrived.
        tick: Tick counter of the reply, 32 bits, wraps.
        subtick: Fraction of a tick in 1/65536.
    """

    t_sent_ns: int
    t_received_ns: int
    tick: int
    subtick: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ClockFitOptions:
    """Settings of the fit.

    Attributes:
        nominal_hz: Tick rate that the controller announces, 1/s.
        window: Number of pings kept.
        slack_s: Reading errors beyond half the round trip that are still believed (late interrupts, a controller that
            answers from a background task), s.
        jump_after: Contradicting pings in a row that make a jump.
        rate_tolerance: Share of the announced rate by which pings after a jump may run off it; more than any
            crystal and any late answer does within a second.
    """

    nominal_hz: float = 2500.0
    window: int = 256
    slack_s: float = 5e-3
    jump_after: int = 3
    rate_tolerance: float = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class ClockFit:
    """The line tick = tick0 + rate_hz * (t - t0), and how good it is.

    Attributes:
        t0_ns: Host monotonic time of the reference point, ns.
        tick0: Tick at the reference point, unwrapped, with its fraction.
        rate_hz: Ticks per host second.
        rate_error_ppm: Deviation of `rate_hz` from the announced rate, 1e-6.
        residual_s: Root mean square distance of the pings used from the line, s.
        min_round_trip_s: Quickest round trip in the window, s.
        span_s: Time between the oldest and the newest ping used, s.
        pings_used: Pings the line rests on.
        pings_rejected: Outliers since the start; only goes up.
        jumps: Jumps of the tick counter since the start; only goes up.
        steady: False once the counter was seen not to follow the host's clock; then the line is that of the newest
            pings, and neither rejections nor jumps are counted.
    """

    t0_ns: int
    tick0: float
    rate_hz: float
    rate_error_ppm: float
    residual_s: float
    min_round_trip_s: float
    span_s: float
    pings_used: int
    pings_rejected: int
    jumps: int
    steady: bool

    def tick_at(self, t_ns: int) -> float:
        """Return the (fractional) tick at host time `t_ns`."""
        return self.tick0 + self.rate_hz * (t_ns - self.t0_ns) * _NS

    def t_ns_at(self, tick: float) -> int:
        """Return the host monotonic time of `tick`, ns."""
        return self.t0_ns + round((tick - self.tick0) / self.rate_hz / _NS)


@dataclass(frozen=True, slots=True)
class _Point:
    t_ns: int
    tick: float
    round_trip_s: float


@dataclass(slots=True)
class ClockFitState:
    """What the fit has seen so far; made by `ClockFitter.init`."""

    points: deque[_Point]
    suspects: list[_Point] = field(default_factory=list)
    last_tick: int = 0
    rejected: int = 0
    jumps: int = 0
    steady: bool = True
    fit: ClockFit | None = None


class ClockFitter:
    """Least squares through the quickest pings of a sliding window."""

    def __init__(self, options: ClockFitOptions) -> None:
        self.options = options

    def init(self) -> ClockFitState:
        """Return the state before the first ping."""
        return ClockFitState(points=deque(maxlen=self.options.window))

    def step(self, state: ClockFitState, ping: PingSample) -> bool:
        """Take one ping into the fit.

        Returns:
            True when the ping was believed, False when it was an outlier (or the first signs of a jump).
        """
        point = self._unwrap(state, ping)
        if not state.steady:
            _keep_newest(state, [*state.points, point][-self.options.jump_after :])
        elif self._contradicts(state.fit, point):
            state.suspects.append(point)
            if len(state.suspects) < self.options.jump_after:
                state.rejected += 1
                return False
            state.steady = self._run_as_announced(state.suspects)
            state.jumps += state.steady
            _keep_newest(state, state.suspects)
        else:
            state.points.append(point)
        state.suspects.clear()
        state.fit = self._solve(state)
        return True

    @staticmethod
    def _unwrap(state: ClockFitState, ping: PingSample) -> _Point:
        step = (ping.tick - state.last_tick + _WRAP // 2) % _WRAP - _WRAP // 2
        state.last_tick += step
        return _Point(
            t_ns=(ping.t_sent_ns + ping.t_received_ns) // 2,
            tick=state.last_tick + ping.subtick / 65536,
            round_trip_s=(ping.t_received_ns - ping.t_sent_ns) * _NS,
        )

    def _run_as_announced(self, points: list[_Point]) -> bool:
        """Tell a counter that has jumped from one that does not follow the host's clock."""
        off = [abs(rate / self.options.nominal_hz - 1.0) for rate in _rates(points)]
        return max(off, default=0.0) <= self.options.rate_tolerance

    def _contradicts(self, fit: ClockFit | None, point: _Point) -> bool:
        # Two points always lie on their line: it takes a third one before anything can be contradicted.
        if fit is None or fit.pings_used < 2:
            return False
        error_s = abs(point.tick - fit.tick_at(point.t_ns)) / fit.rate_hz
        line_s = fit.min_round_trip_s / 2 + self.options.slack_s
        reach = abs(point.t_ns - fit.t0_ns) * _NS / fit.span_s if fit.span_s > 0.0 else 0.0
        # A reading that is off by line_s at either end of the line tilts it by twice that over its span.
        return error_s > point.round_trip_s / 2 + line_s * (1.0 + 2.0 * reach)

    def _solve(self, state: ClockFitState) -> ClockFit:
        t_ns, tick, round_trip = _quickest(state.points)
        t0_ns, tick0 = int(t_ns[-1]), float(tick[-1])
        t = np.asarray((t_ns - t0_ns) * _NS, dtype=np.float64)
        nominal = self.options.nominal_hz
        rate = _slope(t, tick - tick0) if t.size > 1 else nominal
        # A line needs time between its points; before that the announced rate is the better guess.
        rate = rate if np.isfinite(rate) and rate > 0.0 else nominal
        offset = float(np.mean(tick - tick0 - rate * t))
        residual = (tick - tick0 - offset - rate * t) / rate
        return ClockFit(
            t0_ns=t0_ns,
            tick0=tick0 + offset,
            rate_hz=rate,
            rate_error_ppm=(rate / nominal - 1.0) * 1e6,
            residual_s=float(np.sqrt(np.mean(residual**2))),
            min_round_trip_s=float(round_trip.min()),
            span_s=float(np.ptp(t)),
            pings_used=int(t.size),
            pings_rejected=state.rejected,
            jumps=state.jumps,
            steady=state.steady,
        )


def _quickest(points: deque[_Point]) -> tuple[NDArray[np.int64], Floats, Floats]:
    """Return times, ticks and round trips of the better half, or of all those near the minimum."""
    t_ns = np.array([p.t_ns for p in points], dtype=np.int64)
    tick = np.array([p.tick for p in points])
    round_trip = np.array([p.round_trip_s for p in points])
    keep = round_trip <= max(float(np.median(round_trip)), 1.5 * float(round_trip.min()))
    return t_ns[keep], tick[keep], round_trip[keep]


def _keep_newest(state: ClockFitState, points: list[_Point]) -> None:
    state.points.clear()
    state.points.extend(points)


def _rates(points: list[_Point]) -> list[float]:
    """Return the ticks per second from each ping to the next."""
    return [
        (later.tick - earlier.tick) / ((later.t_ns - earlier.t_ns) * _NS)
        for earlier, later in pairwise(points)
        if later.t_ns > earlier.t_ns
    ]


def _slope(t: Floats, tick: Floats) -> float:
    """Return the least-squares slope, ticks per second; NaN when all times are equal."""
    centred = t - t.mean()
    spread = float(centred @ centred)
    return float(centred @ (tick - tick.mean())) / spread if spread > 0.0 else float("nan")
