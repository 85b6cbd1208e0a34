"""Joint, belt and friction against closed forms.

What depends on time is stepped by 20 us as in the emulator; steady states, which no step changes, by 500 us.
"""

import math
from collections.abc import Callable

import numpy as np
import pytest

from mock_dsp.physics.kernels.joint import step_joint

STEP_S = 20e-6
COARSE_S = 500e-6
INERTIA = 0.5
VISCOUS = 0.9

Machine = tuple[np.void, np.void]
MakeMachine = Callable[..., Machine]


def run_joint(machine: Machine, torque_nm: float, time_s: float, step_s: float = STEP_S) -> None:
    for _ in range(round(time_s / step_s)):
        step_joint(machine[0], machine[1], torque_nm, step_s)


def test_the_linear_joint_follows_its_exponential(make_machine: MakeMachine) -> None:
    machine = make_machine()
    run_joint(machine, 0.8, 0.6)
    tau = INERTIA / VISCOUS
    expected = 0.8 / VISCOUS * (1.0 - math.exp(-0.6 / tau))
    angle = 0.8 / VISCOUS * (0.6 - tau * (1.0 - math.exp(-0.6 / tau)))
    # Trapezoidal rule: relative error (h/tau)^2/12, 1e-10; the rest is rounding over 30,000 steps.
    assert machine[0]["motor_speed"] == pytest.approx(expected, rel=1e-8)
    assert machine[0]["motor_angle"] == pytest.approx(angle, rel=1e-8)


STICKING = {
    "coulomb_friction": ({"torque_nm": 0.2}, 0.2),
    "asymmetric_coulomb_friction": ({"positive_nm": 0.2, "negative_nm": 0.1}, 0.2),
    "stribeck_friction": ({"static_nm": 0.2, "coulomb_nm": 0.1}, 0.2),
    "sticky_spot": ({"torque_nm": 0.2, "centre_rad": 0.0}, 0.2),
}


@pytest.mark.parametrize(("effect", "setting"), STICKING.items(), ids=STICKING.keys())
def test_dry_friction_holds_the_joint_exactly_below_its_level(
    effect: str, setting: tuple[dict[str, float], float], make_machine: MakeMachine
) -> None:
    numbers, level = setting
    machine = make_machine({effect: numbers})
    run_joint(machine, 0.999 * level, 0.1)
    assert machine[0]["motor_speed"] == 0.0
    assert machine[0]["motor_angle"] == 0.0


@pytest.mark.parametrize(("effect", "setting"), STICKING.items(), ids=STICKING.keys())
def test_dry_friction_lets_the_joint_go_above_its_level(
    effect: str, setting: tuple[dict[str, float], float], make_machine: MakeMachine
) -> None:
    numbers, level = setting
    machine = make_machine({effect: numbers})
    run_joint(machine, 1.001 * level, 0.1)
    assert machine[0]["motor_speed"] > 0.0


def test_asymmetric_friction_lets_go_earlier_in_the_other_direction(make_machine: MakeMachine) -> None:
    machine = make_machine({"asymmetric_coulomb_friction": {"positive_nm": 0.2, "negative_nm": 0.1}})
    run_joint(machine, -0.15, 0.1)
    assert machine[0]["motor_speed"] < 0.0


def test_load_dependent_friction_takes_its_share_of_the_torque(make_machine: MakeMachine) -> None:
    machine = make_machine({"load_dependent_friction": {"coefficient": 0.25}})
    run_joint(machine, 0.8, 5.0, COARSE_S)
    # The motor's own viscous friction (0.05) stands before the transmission, the joint's (0.85) behind it.
    assert machine[0]["motor_speed"] == pytest.approx(0.8 * 0.75 / (0.85 + 0.05 * 0.75), rel=1e-3)


def test_a_sliding_joint_stops_when_the_closed_form_says_and_stays(make_machine: MakeMachine) -> None:
    machine = make_machine({"coulomb_friction": {"torque_nm": 0.2}})
    machine[0]["motor_speed"] = machine[0]["load_speed"] = 0.5
    stop_s = INERTIA / VISCOUS * math.log(1.0 + VISCOUS * 0.5 / 0.2)
    run_joint(machine, 0.0, stop_s - 2 * STEP_S)
    assert machine[0]["motor_speed"] > 0.0
    run_joint(machine, 0.0, 4 * STEP_S)
    assert machine[0]["motor_speed"] == 0.0


def test_a_reversal_without_sticking_loses_no_time(make_machine: MakeMachine) -> None:
    """Torque -0.5 beats friction 0.2: the joint decelerates with 0.7 and goes on at once with 0.3."""
    machine = make_machine({"coulomb_friction": {"torque_nm": 0.2}})
    machine[0]["motor_speed"] = machine[0]["load_speed"] = 0.1
    tau = INERTIA / VISCOUS
    zero_s = tau * math.log(1.0 + VISCOUS * 0.1 / 0.7)
    run_joint(machine, -0.5, zero_s + 0.2)
    steps = round((zero_s + 0.2) / STEP_S)
    expected = -0.3 / VISCOUS * (1.0 - math.exp(-(steps * STEP_S - zero_s) / tau))
    # Without the cut at the crossing the error would be half a sub-step, 6e-6 rad/s.
    assert machine[0]["motor_speed"] == pytest.approx(expected, abs=2e-7)


TERMINAL_SPEEDS = {
    "coulomb_friction": ({"torque_nm": 0.2}, (0.8 - 0.2) / VISCOUS),
    "load_torque_offset": ({"torque_nm": 0.1}, (0.8 - 0.1) / VISCOUS),
    "asymmetric_viscous_friction": (
        {"positive_nm_s_rad": 0.3, "negative_nm_s_rad": 0.0},
        0.8 / (VISCOUS + 0.3),
    ),
    "quadratic_drag": (
        {"coefficient_nm_s2_rad2": 0.4},
        (math.sqrt(VISCOUS**2 + 4 * 0.4 * 0.8) - VISCOUS) / (2 * 0.4),
    ),
    "stribeck_friction": (
        {"static_nm": 0.3, "coulomb_nm": 0.1, "speed_rad_s": 0.05},
        (0.8 - 0.1) / VISCOUS,  # exp(-(0.78 / 0.05)^2) is nothing
    ),
    "presliding_hysteresis": ({"torque_nm": 0.2, "displacement_rad": 0.3}, (0.8 - 0.2) / VISCOUS),
}


@pytest.mark.parametrize(("effect", "setting"), TERMINAL_SPEEDS.items(), ids=TERMINAL_SPEEDS.keys())
def test_terminal_speed_under_a_constant_torque(
    effect: str, setting: tuple[dict[str, float], float], make_machine: MakeMachine
) -> None:
    numbers, expected = setting
    machine = make_machine({effect: numbers})
    run_joint(machine, 0.8, 8.0, COARSE_S)
    # 8 s are 14 time constants: exp(-14) = 1e-6.
    assert machine[0]["motor_speed"] == pytest.approx(expected, rel=1e-5)


def test_the_eddy_current_brake_peaks_at_its_critical_speed(make_machine: MakeMachine) -> None:
    machine = make_machine({"eddy_current_brake": {"peak_nm": 0.25, "critical_speed_rad_s": 0.2}})
    machine[0]["motor_speed"] = machine[0]["load_speed"] = 0.2
    step_joint(machine[0], machine[1], 0.25 + VISCOUS * 0.2, STEP_S)
    assert machine[0]["motor_speed"] == pytest.approx(0.2, abs=1e-9)


def test_gravity_balances_the_torque_at_its_angle(make_machine: MakeMachine) -> None:
    machine = make_machine({"gravity_unbalance": {"amplitude_nm": 0.2, "phase_rad": 0.0}})
    machine[0]["motor_angle"] = machine[0]["load_angle"] = 4.0 * math.asin(0.5)
    run_joint(machine, 0.1, 0.2)
    assert machine[0]["motor_speed"] == pytest.approx(0.0, abs=1e-12)


def test_torque_ripple_follows_the_motor_angle(make_machine: MakeMachine) -> None:
    machine = make_machine({"torque_ripple": {"amplitude_nm": 0.1, "harmonic": 3.0, "phase_rad": 0.0}})
    machine[0]["motor_angle"] = machine[0]["load_angle"] = math.pi / 6.0
    step_joint(machine[0], machine[1], 0.0, STEP_S)
    assert machine[0]["motor_speed"] == pytest.approx(0.1 * STEP_S / INERTIA, rel=1e-4)


def test_changing_inertia_keeps_the_kinetic_energy(make_machine: MakeMachine) -> None:
    machine = make_machine({"position_dependent_inertia": {"fraction": 0.5, "phase_rad": 0.0}})
    state, plant = machine
    plant["motor_viscous"] = 0.0
    state["load_viscous_now"] = 0.0
    state["motor_speed"] = state["load_speed"] = 10.0
    run_joint(machine, 0.0, 0.5)
    inertia = 0.005 + 0.495 * (1.0 + 0.5 * math.cos(state["load_angle"] / 4.0))
    before = 0.005 + 0.495 * 1.5
    assert inertia * state["load_speed"] ** 2 == pytest.approx(before * 100.0, rel=1e-4)


def test_the_elastic_belt_twists_by_torque_over_stiffness(make_machine: MakeMachine) -> None:
    machine = make_machine(
        {"belt_compliance": {"stiffness_nm_rad": 30.0}, "coulomb_friction": {"torque_nm": 1.0}}
    )
    run_joint(machine, 0.6, 1.0, COARSE_S)
    assert machine[0]["load_angle"] == 0.0
    assert machine[0]["motor_angle"] == pytest.approx(0.6 / 30.0, rel=1e-6)


def test_the_undamped_belt_rings_at_its_frequency_without_losing_energy(make_machine: MakeMachine) -> None:
    machine = make_machine({"belt_compliance": {"stiffness_nm_rad": 30.0, "damping_nm_s_rad": 0.0}})
    state, plant = machine
    plant["motor_viscous"] = 0.0
    state["load_viscous_now"] = 0.0
    state["motor_angle"] = 0.1
    frequency = math.sqrt(30.0 * (1.0 / 0.005 + 1.0 / 0.495))
    periods = 10
    run_joint(machine, 0.0, periods * 2.0 * math.pi / frequency)
    # Position Verlet is fast by (w h)^2 / 24 = 1e-7; the last, broken sub-step costs up to w h / 2 of phase.
    assert state["motor_angle"] - state["load_angle"] == pytest.approx(0.1, rel=1e-5)


def test_inside_the_gap_the_motor_moves_alone(make_machine: MakeMachine) -> None:
    machine = make_machine({"backlash": {"gap_rad": 0.2}})
    run_joint(machine, 0.001, 0.3)
    assert 0.0 < machine[0]["motor_angle"] < 0.1
    assert machine[0]["load_angle"] == 0.0


def test_across_the_gap_the_motor_takes_the_joint_along(make_machine: MakeMachine) -> None:
    machine = make_machine({"backlash": {"gap_rad": 0.2, "stiffness_nm_rad": 200.0}})
    run_joint(machine, 0.8, 6.0, COARSE_S)
    carried = 0.8 - 0.05 * machine[0]["motor_speed"]
    twist = machine[0]["motor_angle"] - machine[0]["load_angle"]
    assert machine[0]["load_speed"] == pytest.approx(0.8 / VISCOUS, rel=1e-4)
    assert twist == pytest.approx(0.1 + carried / 200.0, rel=1e-4)


def test_presliding_friction_is_a_spring_at_first_and_remembers(make_machine: MakeMachine) -> None:
    machine = make_machine({"presliding_hysteresis": {"torque_nm": 0.2, "displacement_rad": 0.4}})
    run_joint(machine, 0.05, 10.0, COARSE_S)
    held = machine[0]["motor_angle"]
    # Four equal springs, sum of yields 2.5: first stiffness 4 * 0.2 / (2.5 * 0.4) = 0.8 N m/rad up to 0.1
    # rad.
    assert held == pytest.approx(0.05 / 0.8, rel=1e-3)
    run_joint(machine, 0.15, 10.0, COARSE_S)
    run_joint(machine, 0.05, 10.0, COARSE_S)
    assert machine[0]["motor_angle"] > 1.5 * held


def test_the_hidden_stop_holds_the_joint_where_spring_and_torque_balance(make_machine: MakeMachine) -> None:
    numbers = {"lower_rad": -1.0, "upper_rad": 1.0, "stiffness_nm_rad": 2.0, "damping_nm_s_rad": 0.5}
    machine = make_machine({"end_stop": numbers})
    run_joint(machine, 0.4, 15.0, COARSE_S)
    assert machine[0]["motor_angle"] == pytest.approx(1.0 + 0.4 / 2.0, rel=1e-4)


def test_the_travel_ends_at_the_rigs_own_stop(make_machine: MakeMachine) -> None:
    machine = make_machine()
    machine[0]["motor_angle"] = machine[0]["load_angle"] = 31.0
    run_joint(machine, 1.0, 5.0, COARSE_S)
    assert machine[0]["motor_angle"] == pytest.approx(31.4, abs=0.01)
