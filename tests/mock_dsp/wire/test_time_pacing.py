"""How fast time may pass: with the wall clock, and not faster than the host's duties."""

import math

from mock_dsp.program.controller import HostDuty
from mock_dsp.wire.pacing import MAX_LAG_NS, DutyGate, WallPace

TICK_HZ = 2500
MS = 1_000_000
LEASE = 625  # 250 ms


def lease(left: int) -> list[HostDuty]:
    return [HostDuty(left_ticks=left, full_ticks=LEASE)]


def test_ticks_follow_the_wall_clock_without_drift() -> None:
    pace = WallPace(TICK_HZ, 0)
    granted = 0
    for t_ns in range(0, 10_000 * MS, 3 * MS):
        due = pace.due_ticks(t_ns)
        pace.grant(due)
        granted += due
        assert granted == t_ns * TICK_HZ // 1_000_000_000


def test_time_that_this_process_was_held_up_is_given_up() -> None:
    pace = WallPace(TICK_HZ, 0)
    most = TICK_HZ * MAX_LAG_NS // 1_000_000_000
    due = pace.due_ticks(10_000 * MS)
    assert due == most
    pace.grant(due)
    assert pace.due_ticks(10_000 * MS + 4 * MS) == 10


def test_a_restart_forgets_the_time_before() -> None:
    pace = WallPace(TICK_HZ, 0)
    pace.restart(5000 * MS)
    assert pace.due_ticks(5004 * MS) == 10


def test_without_duties_nothing_holds_the_time() -> None:
    assert DutyGate(TICK_HZ).allow([], 0) == math.inf


def test_time_runs_to_the_half_of_the_lease_and_waits_there() -> None:
    gate = DutyGate(TICK_HZ)
    assert gate.allow(lease(LEASE), 0) == LEASE - LEASE // 2
    assert gate.allow(lease(LEASE // 2), 0) == 0


def test_the_tightest_duty_counts() -> None:
    duties = [*lease(LEASE), HostDuty(left_ticks=140, full_ticks=256)]
    assert DutyGate(TICK_HZ).allow(duties, 0) == 12


def test_a_renewed_lease_lets_time_go_on() -> None:
    gate = DutyGate(TICK_HZ)
    gate.allow(lease(312), 0)
    assert gate.allow(lease(LEASE), 100 * MS) == 313


def test_a_dead_host_gets_the_whole_duty_on_the_wall_clock_and_no_more() -> None:
    gate = DutyGate(TICK_HZ)
    assert gate.allow(lease(312), 0) == 0
    assert gate.allow(lease(312), 249 * MS) == 0
    assert gate.allow(lease(312), 250 * MS) == math.inf
    assert gate.allow(lease(62), 251 * MS) == math.inf


def test_a_host_that_comes_back_is_waited_for_again() -> None:
    gate = DutyGate(TICK_HZ)
    gate.allow(lease(312), 0)
    gate.allow(lease(312), 300 * MS)
    gate.allow(lease(LEASE), 310 * MS)
    assert gate.allow(lease(312), 320 * MS) == 0
