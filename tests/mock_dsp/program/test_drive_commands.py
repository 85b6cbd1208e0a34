"""The table of docs/protocol.md, section 8: every command in every drive state, through the link."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

from daq.protocol.codes import DriveState, EventCode, FaultBit, ParameterId, StatusCode
from daq.protocol.commands import (
    Arm,
    ClearFault,
    Disarm,
    Estop,
    KeepAlive,
    ParamSave,
    ParamSet,
    RunAbort,
    SetpointBegin,
)
from daq.protocol.message import Command
from daq.protocol.replies import ArmReply, ClearFaultReply, KeepAliveReply
from mock_dsp.program.parameters import ParameterStore

if TYPE_CHECKING:
    from tests.mock_dsp.conftest import SESSION, Bench, RunMaker
else:
    SESSION = 7

LIMITS_CRC = ParameterStore({}).limits_crc()
ARM = Arm(session=SESSION, lease_ms=2000, limits_crc=LIMITS_CRC)
SETPOINTS = SetpointBegin(divisor=1, flags=0)


def enter_idle(bench: Bench, make_run: RunMaker) -> None:
    bench.greet()


def enter_armed(bench: Bench, make_run: RunMaker) -> None:
    bench.arm()


def enter_running(bench: Bench, make_run: RunMaker) -> None:
    bench.arm()
    bench.ask(make_run())
    bench.run_ticks(30)


def enter_ramping(bench: Bench, make_run: RunMaker) -> None:
    enter_running(bench, make_run)
    bench.ask(RunAbort())
    bench.run_ticks(10)


def enter_safe_timeout(bench: Bench, make_run: RunMaker) -> None:
    bench.arm(lease_ms=50)
    bench.run_ticks(200)


def enter_fault(bench: Bench, make_run: RunMaker) -> None:
    bench.arm()
    bench.plant.trip_tick = bench.plant.tick + 5
    bench.run_ticks(10)


def enter_stopped(bench: Bench, make_run: RunMaker) -> None:
    bench.arm()
    bench.ask(Estop())


ENTER: dict[str, Callable[[Bench, RunMaker], None]] = {
    "idle": enter_idle,
    "armed": enter_armed,
    "running": enter_running,
    "ramping": enter_ramping,
    "safe_timeout": enter_safe_timeout,
    "fault": enter_fault,
    "stopped": enter_stopped,
}

OK, CLAMPED, WRONG_STATE = StatusCode.OK, StatusCode.CLAMPED, StatusCode.WRONG_STATE
FAULT, ESTOP = StatusCode.FAULT_LATCHED, StatusCode.ESTOP_LATCHED

TABLE: list[tuple[Command, dict[str, StatusCode]]] = [
    (ARM, {"idle": OK, "armed": WRONG_STATE, "running": WRONG_STATE, "ramping": WRONG_STATE,
           "safe_timeout": FAULT, "fault": FAULT, "stopped": ESTOP}),
    (KeepAlive(session=SESSION), {"idle": WRONG_STATE, "armed": OK, "running": OK, "ramping": OK,
                                  "safe_timeout": FAULT, "fault": FAULT, "stopped": ESTOP}),
    (Disarm(), dict.fromkeys(ENTER, OK)),
    (RunAbort(), dict.fromkeys(ENTER, OK)),
    (Estop(), dict.fromkeys(ENTER, OK)),
    (ClearFault(), dict.fromkeys(ENTER, OK)),
    (SETPOINTS, {"idle": WRONG_STATE, "armed": OK, "running": WRONG_STATE, "ramping": WRONG_STATE,
                 "safe_timeout": FAULT, "fault": FAULT, "stopped": ESTOP}),
    (ParamSave(), {"idle": OK, "armed": WRONG_STATE, "running": WRONG_STATE, "ramping": WRONG_STATE,
                   "safe_timeout": OK, "fault": OK, "stopped": OK}),
]  # fmt: skip


@pytest.mark.parametrize("where", ENTER)
@pytest.mark.parametrize(("command", "expected"), TABLE, ids=lambda value: type(value).__name__)
def test_a_command_is_answered_as_the_table_says(
    bench: Bench, make_run: RunMaker, where: str, command: Command, expected: dict[str, StatusCode]
) -> None:
    ENTER[where](bench, make_run)
    assert bench.status_of(command) == expected[where]


@pytest.mark.parametrize("where", ["idle", "running", "ramping", "safe_timeout", "fault", "stopped"])
def test_run_is_accepted_in_armed_only(bench: Bench, make_run: RunMaker, where: str) -> None:
    ENTER[where](bench, make_run)
    assert bench.status_of(make_run()) != StatusCode.OK


@pytest.mark.parametrize("where", ENTER)
def test_an_emergency_stop_latches_in_every_state_and_needs_no_session(
    bench: Bench, make_run: RunMaker, where: str
) -> None:
    ENTER[where](bench, make_run)
    bench.ask(Estop())
    assert bench.drive_state() is DriveState.FAULT
    assert not bench.plant.parameters.pwm_on
    assert bench.status_of(ARM) == StatusCode.ESTOP_LATCHED


def test_an_emergency_stop_is_obeyed_before_any_hello(bench: Bench) -> None:
    assert bench.status_of(Estop()) == StatusCode.OK


def test_clear_fault_and_arm_lead_out_of_an_emergency_stop(bench: Bench, make_run: RunMaker) -> None:
    enter_stopped(bench, make_run)
    assert bench.status_of(ClearFault()) == StatusCode.OK
    assert bench.drive_state() is DriveState.IDLE
    assert bench.status_of(ARM) == StatusCode.OK


def test_a_fault_whose_cause_remains_cannot_be_cleared(bench: Bench, make_run: RunMaker) -> None:
    enter_fault(bench, make_run)
    bench.plant.conditions = (FaultBit.OVER_CURRENT,)
    reply = bench.ask(ClearFault())
    assert isinstance(reply, ClearFaultReply)
    assert (reply.status, reply.faults) == (StatusCode.FAULT_LATCHED, 1 << FaultBit.OVER_CURRENT)
    assert bench.drive_state() is DriveState.FAULT


def test_a_trip_switches_off_at_its_tick_and_is_told(bench: Bench, make_run: RunMaker) -> None:
    bench.arm()
    bench.ask(make_run())
    bench.plant.trip, bench.plant.trip_tick = FaultBit.TRAVEL, 40
    bench.run_ticks(100)
    fault = next(event for event in bench.events if event.code == EventCode.FAULT)
    assert (fault.arg, fault.tick) == (FaultBit.TRAVEL, 41)
    assert not bench.plant.parameters.pwm_on
    assert (bench.plant.played()[41:] == 0.0).all()


def test_arm_checks_session_then_limits(bench: Bench) -> None:
    bench.greet()
    wrong_both = Arm(session=SESSION + 1, lease_ms=250, limits_crc=LIMITS_CRC ^ 1)
    assert bench.status_of(wrong_both) == StatusCode.WRONG_SESSION
    wrong_limits = Arm(session=SESSION, lease_ms=250, limits_crc=LIMITS_CRC ^ 1)
    assert bench.status_of(wrong_limits) == StatusCode.WRONG_LIMITS


def test_arm_wants_the_limits_in_force_not_the_default_ones(bench: Bench) -> None:
    bench.greet()
    bench.ask(ParamSet(parameter=ParameterId.CURRENT_LIMIT_A, raw=1500))
    assert bench.status_of(ARM) == StatusCode.WRONG_LIMITS


@pytest.mark.parametrize(
    ("asked_ms", "granted_ms", "status"),
    [
        (0, 250, OK),
        (50, 50, OK),
        (2000, 2000, OK),
        (1, 50, CLAMPED),
        (9999, 2000, CLAMPED),
    ],
)
def test_the_lease_is_granted_within_its_limits(
    bench: Bench, asked_ms: int, granted_ms: int, status: StatusCode
) -> None:
    bench.greet()
    reply = bench.ask(Arm(session=SESSION, lease_ms=asked_ms, limits_crc=LIMITS_CRC))
    assert isinstance(reply, ArmReply)
    assert (reply.lease_ms, reply.status) == (granted_ms, status)


def test_a_keep_alive_of_another_session_is_refused(armed: Bench) -> None:
    assert armed.status_of(KeepAlive(session=SESSION + 1)) == StatusCode.WRONG_SESSION


def test_a_keep_alive_tells_what_was_left(armed: Bench) -> None:
    armed.run_ticks(250)
    reply = armed.ask(KeepAlive(session=SESSION))
    assert isinstance(reply, KeepAliveReply)
    assert reply.lease_left_ms == 1900


def test_a_keep_alive_comes_too_late_for_the_ramp_of_a_lost_lease(bench: Bench, make_run: RunMaker) -> None:
    bench.arm(lease_ms=50)
    bench.ask(make_run())
    bench.run_ticks(130)
    assert bench.drive_state() is DriveState.RAMPING
    assert bench.status_of(KeepAlive(session=SESSION)) == StatusCode.WRONG_STATE
