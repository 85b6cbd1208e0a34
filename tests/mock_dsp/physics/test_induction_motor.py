"""The motor against its equivalent circuit and the design numbers."""

import cmath
import math
from collections.abc import Callable

import numpy as np
import pytest

from mock_dsp.physics.kernels.motor import stator_current, step_motor

STEP_S = 20e-6
RS, RR, LS, LM = 35.58, 87.44, 0.16 + 0.884, 0.884

Machine = tuple[np.void, np.void]
MakeMachine = Callable[..., Machine]


@pytest.mark.parametrize("slip", [1.0, 0.5, 0.05])
def test_the_steady_state_is_that_of_the_equivalent_circuit(slip: float, make_machine: MakeMachine) -> None:
    state, plant = make_machine()
    omega, volts, time_s = 2.0 * math.pi * 30.0, 100.0, 0.4
    state["motor_speed"] = omega * (1.0 - slip) / 2.0
    torque = 0.0
    for step in range(round(time_s / STEP_S)):
        # Voltage at the middle of the sub-step, where the midpoint rule takes it.
        phase = omega * (step + 0.5) * STEP_S
        torque = step_motor(state, plant, volts * math.cos(phase), volts * math.sin(phase), STEP_S)
    rotor = RR / slip + 1j * omega * LS
    impedance = RS + 1j * omega * LS + (omega * LM) ** 2 / rotor
    expected = volts / impedance * cmath.exp(1j * omega * time_s)
    rotor_power = 1.5 * abs(volts / impedance * omega * LM / rotor) ** 2 * RR / slip
    assert complex(*stator_current(state, plant)) == pytest.approx(expected, rel=1e-4)
    assert torque == pytest.approx(2.0 * rotor_power / omega, rel=1e-4)


def test_one_ampere_gives_one_newton_metre_at_the_nominal_flux_current(make_machine: MakeMachine) -> None:
    """Field orientation by hand: i_d = 0.4455 A, i_q = 1 A, rotor flux on the alpha axis."""
    state, plant = make_machine()
    state["rotor_alpha"] = LM * 0.4455
    sigma_ls = LS - LM * LM / LS
    state["stator_alpha"] = sigma_ls * 0.4455 + LM / LS * state["rotor_alpha"]
    state["stator_beta"] = sigma_ls * 1.0
    assert stator_current(state, plant) == pytest.approx((0.4455, 1.0))
    # A vanishing step shows the torque of this very state.
    assert step_motor(state, plant, 0.0, 0.0, 1e-12) == pytest.approx(1.0, abs=1e-3)
