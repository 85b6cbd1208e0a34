"""The size of blocks, the seed and the compiler do not show in the samples."""

import os
import subprocess
import sys
from dataclasses import fields

import numpy as np
import pytest

from mock_dsp.control.parameters import FastLoopParameters
from mock_dsp.physics.noise import CHUNK_TICKS, NoiseSource
from mock_dsp.physics.rig import EmulatedRig, RigTrace
from mock_dsp.scenario.effects import EFFECTS
from mock_dsp.scenario.schema import Effect, Scenario

ARRAYS = [field.name for field in fields(RigTrace) if field.name not in ("first_tick", "ticks_done", "trip")]
EVERYTHING = tuple(Effect(id=effect_id) for effect_id in EFFECTS)


def start(effects: tuple[Effect, ...] = (), seed: int = 1) -> EmulatedRig:
    rig = EmulatedRig.from_scenario(Scenario(name="test", seed=seed, effects=effects))
    rig.set_parameters(FastLoopParameters(pwm_on=True, centring_on=True))
    return rig


def reference(ticks: int) -> np.ndarray:
    return 0.8 * np.sin(np.arange(ticks) / 700.0)


@pytest.mark.parametrize("effects", [(), EVERYTHING], ids=["nothing hidden", "every effect at once"])
@pytest.mark.parametrize("cut", [1, 777, CHUNK_TICKS, CHUNK_TICKS + 1])
def test_two_blocks_give_exactly_what_one_gives(cut: int, effects: tuple[Effect, ...]) -> None:
    command = reference(CHUNK_TICKS + 500)
    whole = start(effects).run(command)
    rig = start(effects)
    first, second = rig.run(command[:cut]), rig.run(command[cut:])
    assert second.first_tick == cut
    for name in ARRAYS:
        assert np.array_equal(
            np.concatenate((getattr(first, name), getattr(second, name))), getattr(whole, name)
        )


def test_an_empty_block_changes_nothing() -> None:
    rig = start()
    rig.run(reference(10))
    assert rig.run(np.empty(0)).ticks_done == 0
    assert rig.tick == 10


def test_the_seed_decides_the_noise() -> None:
    command = reference(300)
    same, again, other = start(seed=5).run(command), start(seed=5).run(command), start(seed=6).run(command)
    assert np.array_equal(same.position_counts, again.position_counts)
    assert not np.array_equal(same.position_counts, other.position_counts)


def test_a_reset_rig_starts_over() -> None:
    rig = start(EVERYTHING)
    before = rig.run(reference(400))
    rig.reset()
    assert rig.tick == 0
    assert np.array_equal(rig.run(reference(400)).current_counts, before.current_counts)


def test_noise_at_a_tick_does_not_depend_on_what_was_taken_before() -> None:
    later = NoiseSource(9).take(3 * CHUNK_TICKS + 10, 5)
    source = NoiseSource(9)
    source.take(0, 100)
    source.take(CHUNK_TICKS, 7)
    assert np.array_equal(source.take(3 * CHUNK_TICKS + 10, 5), later)


PROGRAM = """
import numpy as np
from mock_dsp.control.parameters import FastLoopParameters
from mock_dsp.physics.rig import EmulatedRig
from mock_dsp.scenario.effects import EFFECTS
from mock_dsp.scenario.schema import Effect, Scenario
for effects in ((), tuple(Effect(id=name) for name in EFFECTS)):
    rig = EmulatedRig.from_scenario(Scenario(name="test", seed=1, effects=effects))
    rig.set_parameters(FastLoopParameters(pwm_on=True, centring_on=True))
    trace = rig.run(0.8 * np.sin(np.arange(40) / 7.0))
    print(*(repr(float(value)) for value in trace.true_speed_rad_s))
    print(*trace.current_counts)
"""


def run_program(disable_jit: str) -> list[list[float]]:
    environment = os.environ | {"NUMBA_DISABLE_JIT": disable_jit}
    command = [sys.executable, "-W", "error", "-c", PROGRAM]
    output = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
    return [[float(word) for word in line.split()] for line in output.splitlines()]


@pytest.mark.slow
def test_the_interpreted_kernels_give_the_same_numbers() -> None:
    compiled, interpreted = run_program("0"), run_program("1")
    assert len(interpreted) == 4
    for fast, plain in zip(compiled, interpreted, strict=True):
        # Contracted multiply-adds and libm differ in the last bits only.
        assert fast == pytest.approx(plain, rel=1e-9, abs=1e-12)
