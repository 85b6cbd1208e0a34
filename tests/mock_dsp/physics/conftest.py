"""Builders of emulated machines and rigs with chosen effects."""

from collections.abc import Callable, Mapping

import numpy as np
import pytest

from mock_dsp.control.parameters import FastLoopParameters
from mock_dsp.physics.plant import compile_plant, initial_state
from mock_dsp.physics.rig import EmulatedRig
from mock_dsp.scenario.rig_constants import RigConstants, SensorConstants
from mock_dsp.scenario.schema import Effect, Fault, Scenario

QUIET = RigConstants(sensors=SensorConstants(current_noise_a=0.0, potentiometer_noise_lsb=0.0))

Machine = tuple[np.void, np.void]
MakeMachine = Callable[..., Machine]
MakeRig = Callable[..., EmulatedRig]


def _scenario(
    effects: Mapping[str, dict[str, float]], faults: tuple[Fault, ...], rig: RigConstants
) -> Scenario:
    chosen = tuple(Effect(id=effect_id, parameters=numbers) for effect_id, numbers in effects.items())
    return Scenario(name="test", seed=1, rig=rig, effects=chosen, faults=faults)


@pytest.fixture
def make_machine() -> MakeMachine:
    """Return a builder of (state, plant) for effects given as {id: {parameter: value}}."""

    def build(effects: Mapping[str, dict[str, float]] | None = None) -> Machine:
        plant = compile_plant(_scenario(effects or {}, (), QUIET))
        return initial_state(plant, 0.0)[0], plant[0]

    return build


@pytest.fixture
def make_rig() -> MakeRig:
    """Return a builder of a rig with the bridge on and its rotor magnetised."""

    def build(
        effects: Mapping[str, dict[str, float]] | None = None,
        *,
        faults: tuple[Fault, ...] = (),
        noisy: bool = False,
        parameters: FastLoopParameters | None = None,
    ) -> EmulatedRig:
        rig = EmulatedRig.from_scenario(_scenario(effects or {}, faults, RigConstants() if noisy else QUIET))
        rig.set_parameters(parameters or FastLoopParameters(pwm_on=True))
        rig.run(np.zeros(250))
        return rig

    return build
