"""The lease, the ramps to zero, the watchdog, and what the host is told of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from daq.protocol.codes import DriveState, EventCode, FaultBit, ParameterId
from daq.protocol.commands import Disarm, KeepAlive, ParamSet, RunAbort
from mock_dsp.program.controller import WATCHDOG_TICKS

if TYPE_CHECKING:
    from tests.mock_dsp.conftest import Bench, RunMaker

LEASE_MS = 250
LEASE_TICKS = 625
RAMP_TICKS = 125  # 50 ms, the longest allowed


def keep_running(bench: Bench, ticks: int) -> None:
    """Let ticks pass in steps that the watchdog allows."""
    for _ in range(ticks // 25):
        bench.run_ticks(25)


def test_a_lost_lease_ramps_to_zero_in_50_ms_and_latches(bench: Bench, make_run: RunMaker) -> None:
    bench.arm(LEASE_MS)
    bench.ask(make_run(offset_ua=500_000, amplitude_ua=0))
    keep_running(bench, LEASE_TICKS + RAMP_TICKS)
    played = bench.plant.played()
    assert np.all(played[1:LEASE_TICKS] == 0.5)
    ramp = played[LEASE_TICKS : LEASE_TICKS + RAMP_TICKS]
    assert np.all(np.diff(ramp) < 0.0) and ramp[-1] == 0.0
    assert bench.drive_state() is DriveState.SAFE_TIMEOUT
    assert not bench.plant.parameters.pwm_on
    assert EventCode.LEASE_LOST in bench.event_codes()


def test_a_lease_lost_without_current_latches_at_once(bench: Bench) -> None:
    bench.arm(LEASE_MS)
    keep_running(bench, LEASE_TICKS)
    assert bench.drive_state() is DriveState.SAFE_TIMEOUT


def test_keep_alives_hold_the_lease(bench: Bench, make_run: RunMaker) -> None:
    bench.arm(LEASE_MS)
    bench.ask(make_run())
    for _ in range(20):
        keep_running(bench, 150)
        bench.ask(KeepAlive(session=7))
    assert bench.drive_state() is DriveState.RUNNING


def test_an_abort_ramps_from_the_last_value_and_stays_armed(armed: Bench, make_run: RunMaker) -> None:
    armed.ask(make_run(offset_ua=-800_000, amplitude_ua=0))
    keep_running(armed, 50)
    armed.ask(RunAbort())
    assert armed.drive_state() is DriveState.RAMPING
    keep_running(armed, RAMP_TICKS)
    ramp = armed.plant.played()[-RAMP_TICKS:]
    last_count_a = np.floor(-0.8 * 8192 + 0.5) / 8192
    assert ramp == pytest.approx(last_count_a * (1.0 - np.arange(1, RAMP_TICKS + 1) / RAMP_TICKS))
    assert armed.drive_state() is DriveState.ARMED


def test_a_disarm_during_the_ramp_changes_its_end_not_its_course(armed: Bench, make_run: RunMaker) -> None:
    armed.ask(make_run(offset_ua=800_000, amplitude_ua=0))
    keep_running(armed, 25)
    armed.ask(RunAbort())
    keep_running(armed, 50)
    armed.ask(Disarm())
    keep_running(armed, 75)
    assert armed.drive_state() is DriveState.IDLE
    assert np.diff(armed.plant.played()[-RAMP_TICKS:]) == pytest.approx(-0.8 / RAMP_TICKS, abs=1e-5)


def test_the_ramp_takes_the_time_that_the_parameter_says(armed: Bench, make_run: RunMaker) -> None:
    armed.ask(Disarm())
    armed.ask(ParamSet(parameter=ParameterId.RAMP_TIME_S, raw=10))
    armed.arm()
    armed.ask(make_run(offset_ua=800_000, amplitude_ua=0))
    keep_running(armed, 25)
    armed.ask(Disarm())
    armed.run_ticks(25)
    assert armed.drive_state() is DriveState.IDLE


def test_a_background_task_that_stands_still_trips_the_watchdog(armed: Bench) -> None:
    armed.run_ticks(WATCHDOG_TICKS - 1)
    assert armed.drive_state() is DriveState.ARMED
    armed.run_ticks(WATCHDOG_TICKS)
    faults = [event.arg for event in armed.events if event.code == EventCode.FAULT]
    assert faults == [FaultBit.WATCHDOG]
    assert armed.drive_state() is DriveState.FAULT


def test_the_watchdog_sleeps_while_the_drive_is_off(bench: Bench) -> None:
    bench.greet()
    bench.run_ticks(10 * WATCHDOG_TICKS)
    assert bench.drive_state() is DriveState.IDLE
