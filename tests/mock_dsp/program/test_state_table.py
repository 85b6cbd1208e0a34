"""The state machine as data: what must hold for every entry, whatever the program does with it."""

import pytest

from daq.protocol.codes import StatusCode
from mock_dsp.program.states import LATCHED, POWERED, RAMPS, TRANSITIONS, Phase, Stimulus, follow, refuse


@pytest.mark.parametrize("phase", Phase)
def test_an_emergency_stop_ends_in_fault_from_every_phase(phase: Phase) -> None:
    assert follow(phase, Stimulus.ESTOP) is Phase.FAULT


@pytest.mark.parametrize("phase", Phase)
def test_a_trip_ends_in_fault_from_every_phase(phase: Phase) -> None:
    assert follow(phase, Stimulus.TRIP) is Phase.FAULT


@pytest.mark.parametrize("phase", [phase for phase in Phase if phase in LATCHED])
def test_only_clear_leads_out_of_the_latched_phases(phase: Phase) -> None:
    ways_out = {
        stimulus for (start, stimulus), end in TRANSITIONS.items() if start is phase and end not in LATCHED
    }
    assert ways_out == {Stimulus.CLEAR}


@pytest.mark.parametrize("stimulus", Stimulus)
def test_the_bridge_is_switched_on_by_arm_only(stimulus: Stimulus) -> None:
    switched_on = {
        start
        for (start, cause), end in TRANSITIONS.items()
        if cause is stimulus and start not in POWERED and end in POWERED
    }
    assert switched_on == ({Phase.IDLE} if stimulus is Stimulus.ARM else set())


@pytest.mark.parametrize("stimulus", Stimulus)
def test_a_ramp_after_a_lost_lease_ends_latched_whatever_comes(stimulus: Stimulus) -> None:
    assert follow(Phase.RAMPING_TO_SAFE, stimulus) in LATCHED | {Phase.RAMPING_TO_SAFE}


@pytest.mark.parametrize("phase", [phase for phase in Phase if phase in POWERED])
def test_a_lost_lease_moves_every_powered_phase_towards_safety(phase: Phase) -> None:
    assert follow(phase, Stimulus.LEASE_LOST) in {Phase.RAMPING_TO_SAFE, Phase.SAFE_TIMEOUT}


@pytest.mark.parametrize("phase", [phase for phase in Phase if phase in RAMPS])
def test_a_finished_ramp_leaves_the_ramp(phase: Phase) -> None:
    assert follow(phase, Stimulus.RAMP_DONE) not in RAMPS


@pytest.mark.parametrize(
    ("phase", "estop", "status"),
    [
        (Phase.IDLE, False, StatusCode.OK),
        (Phase.ARMED, False, StatusCode.WRONG_STATE),
        (Phase.RUNNING, False, StatusCode.WRONG_STATE),
        (Phase.RAMPING_TO_IDLE, False, StatusCode.WRONG_STATE),
        (Phase.SAFE_TIMEOUT, False, StatusCode.FAULT_LATCHED),
        (Phase.FAULT, False, StatusCode.FAULT_LATCHED),
        (Phase.FAULT, True, StatusCode.ESTOP_LATCHED),
    ],
)
def test_arm_is_refused_with_the_reason(phase: Phase, estop: bool, status: StatusCode) -> None:
    assert refuse(phase, Stimulus.ARM, estop=estop) is status
