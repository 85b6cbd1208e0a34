"""Counts that the program sees: converters, potentiometer, and the shortcut for 16 conversions."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from mock_dsp.physics.kernels.sensors import convert_current, read_potentiometer
from mock_dsp.physics.plant import compile_plant, initial_state
from mock_dsp.scenario.schema import Scenario

SILENCE = np.zeros(3)

Machine = tuple[np.void, np.void]
MakeMachine = Callable[..., Machine]


@pytest.mark.parametrize(
    ("current_a", "counts"), [(0.0, 0), (1.0, 8192), (0.001, 16), (0.0009, 0), (5.0, 32752), (-5.0, -32768)]
)
def test_the_converter_has_12_bits_over_4_amperes(current_a: float, counts: int) -> None:
    assert convert_current(current_a) == counts


@pytest.mark.parametrize(
    ("angle", "counts"),
    [(0.0, 32768), (10.0 * math.pi, 65535), (-10.0 * math.pi, 0), (math.pi, 32768 + 3280)],
)
def test_a_quiet_potentiometer_moves_in_12_bit_steps(
    angle: float, counts: int, make_machine: MakeMachine
) -> None:
    state, plant = make_machine()
    state["motor_angle"] = angle
    read_potentiometer(state, plant, SILENCE)
    assert state["position_counts"] == counts


def test_the_reading_is_distributed_as_the_sum_of_16_conversions() -> None:
    plant = compile_plant(Scenario(name="noisy"))
    state = initial_state(plant, 0.0)
    generator = np.random.default_rng(3)
    steps = 1234.3 + generator.uniform(0.0, 1.0)
    state["motor_angle"] = (steps / 4096.0 - 0.5) * 20.0 * math.pi
    noise = generator.standard_normal((40_000, 3))
    readings = np.empty(len(noise))
    for index, row in enumerate(noise):
        read_potentiometer(state[0], plant[0], row)
        readings[index] = state["position_counts"][0]
    sums = np.floor(steps + 0.6 * generator.standard_normal((40_000, 16)) + 0.5).sum(axis=1)
    # Five standard errors of a difference of means (2.7 sqrt(2/40,000) = 0.019), and of standard deviations.
    assert readings.mean() == pytest.approx(sums.mean(), abs=0.1)
    assert readings.std() == pytest.approx(sums.std(), rel=0.03)


def test_a_bent_potentiometer_deviates_by_its_sine(make_machine: MakeMachine) -> None:
    state, plant = make_machine({"potentiometer_nonlinearity": {"amplitude_rad": 0.4, "cycles": 5.0}})
    state["motor_angle"] = math.pi  # a quarter of a cycle
    for _ in range(3):
        read_potentiometer(state, plant, SILENCE)
    shown = (state["position_counts"] - 32768) * 20.0 * math.pi / 65536.0
    assert shown == pytest.approx(math.pi + 0.4, abs=0.008)


def test_a_repeated_reading_is_counted(make_machine: MakeMachine) -> None:
    state, plant = make_machine()
    for _ in range(5):
        read_potentiometer(state, plant, SILENCE)
    assert state["repeats"] == 5
