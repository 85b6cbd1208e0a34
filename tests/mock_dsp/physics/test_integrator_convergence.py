"""Halving the 20 us sub-step changes nothing material.

The machine is driven open loop by fixed duties, so that only the integrators differ: in the closed loop the
converters' rounding would turn a difference of 1e-9 into one of a whole count.
"""

import numpy as np
import pytest

from mock_dsp.physics.kernels.period import run_period_switching
from mock_dsp.physics.plant import compile_plant, initial_state
from mock_dsp.scenario.schema import Effect, Scenario

TICK_S = 400e-6
TICKS = 5000

# Largest change of the motor speed when the sub-step is halved, as a share of its swing. Measured: 4e-6 for
# the linear joint, 1e-5 with dry friction, 2e-5 with the belt, 1.3e-3 with backlash: there the moment of
# contact is found to within a sub-step only, and bouncing teeth spread any difference.
CASES = {
    "nothing hidden": ((), 1e-5),
    "stribeck_friction": (("stribeck_friction",), 3e-5),
    "coulomb_friction": (("coulomb_friction",), 3e-5),
    "belt_compliance": (("belt_compliance",), 6e-5),
    "backlash": (("backlash",), 4e-3),
    "several on the joint": (
        (
            "stribeck_friction",
            "quadratic_drag",
            "gravity_unbalance",
            "torque_ripple",
            "presliding_hysteresis",
        ),
        3e-5,
    ),
}


def speeds(effects: tuple[str, ...], substeps: int) -> np.ndarray:
    """Return the motor speed at each tick under a rotating voltage whose frequency swings through zero."""
    scenario = Scenario(name="test", effects=tuple(Effect(id=effect) for effect in effects))
    plant = compile_plant(scenario, substeps)
    state = initial_state(plant, 0.0)
    time = TICK_S * np.arange(TICKS)
    angle = 40.0 * np.cumsum(np.sin(2.0 * np.pi * 1.0 * time)) * TICK_S * 2.0 * np.pi
    speed = np.empty(TICKS)
    for tick in range(TICKS):
        for name, shift in (("duty_a", 0.0), ("duty_b", 2.0), ("duty_c", 4.0)):
            state[name] = 0.5 + 0.15 * np.cos(angle[tick] - shift * np.pi / 3.0)
        run_period_switching(state[0], plant[0], TICK_S)
        speed[tick] = state["motor_speed"][0]
    return speed


@pytest.mark.parametrize(("effects", "share"), CASES.values(), ids=CASES.keys())
def test_halving_the_sub_step_changes_nothing_material(effects: tuple[str, ...], share: float) -> None:
    coarse, fine = speeds(effects, 20), speeds(effects, 40)
    assert np.max(np.abs(coarse - fine)) < share * np.ptp(coarse)


def test_the_linear_rig_converges_with_the_second_order() -> None:
    speed = {substeps: speeds((), substeps) for substeps in (20, 40, 640)}
    error = {substeps: np.sqrt(np.mean((speed[substeps] - speed[640]) ** 2)) for substeps in (20, 40)}
    # Second order is a factor of 4; pulse edges inside a sub-step scatter about it.
    assert error[20] > 3.0 * error[40]
