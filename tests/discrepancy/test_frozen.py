"""Compiled and interpreted kernels say the same, and simulating leaves the parameters as they were."""

import os
import subprocess
import sys

import numpy as np
from numpy.typing import NDArray

from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.frozen import freeze
from discrepancy.simulation.kernels.joint import simulate_record

PROGRAM = """
import numpy as np
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.joint import simulate_record
time = np.arange(150) * 4e-3
current = np.sin(9.0 * time) + 0.3 * np.sin(31.0 * time)
plain = s.neutral_vector()
plain[s.INERTIA], plain[s.VISCOUS], plain[s.TORQUE_CONSTANT], plain[s.COULOMB] = 5e-4, 5e-4, 0.05, 4e-3
belt = plain.copy()
belt[s.LOAD_SHARE], belt[s.STIFFNESS], belt[s.LOAD_FRICTION_SHARE], belt[s.GAP] = 0.5, 2.0, 0.7, 0.02
belt[s.STRIBECK_EXTRA], belt[s.GRAVITY_WAVE], belt[s.GRAVITY_SIN], belt[s.CURRENT_LAG] = 3e-3, 1.0, 0.01, 2e-3
belt[s.TORQUE_LIMIT] = 0.04
sprung = plain.copy()
sprung[s.PRESLIDING_LEVEL], sprung[s.PRESLIDING_STIFFNESS], sprung[s.POT_WAVE], sprung[s.POT_SIN] = 4e-3, 0.2, 1.0, 0.02
sprung[s.SPLINE_DRIVER], sprung[s.SPLINE_COUNT] = s.SPLINE_OVER_SPEED, 3
sprung[s.SPLINE_X : s.SPLINE_X + 3], sprung[s.SPLINE_Y : s.SPLINE_Y + 3] = (-9.0, 0.0, 9.0), (2e-3, 0.0, -3e-3)
for vector in (plain, belt, sprung):
    found = simulate_record(vector, time, current, np.sin(time), np.array([-1, 60]), np.array([[0.0, 0.0], [1.0, 0.2]]))
    print(*(repr(float(value)) for value in found[0]))
"""


def simulate(disable_jit: str) -> list[list[float]]:
    environment = os.environ | {"NUMBA_DISABLE_JIT": disable_jit}
    command = [sys.executable, "-W", "error", "-c", PROGRAM]
    output = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
    return [[float(word) for word in line.split()] for line in output.splitlines()]


def test_the_interpreted_kernel_gives_the_same_numbers() -> None:
    compiled, interpreted = np.array(simulate("0")), np.array(simulate("1"))
    assert compiled.shape == (3, 150)
    assert np.ptp(compiled, axis=1).min() > 0.5
    # The same operations in the same order; libm's last bits may differ from one build to the next.
    assert np.allclose(compiled, interpreted, rtol=1e-9, atol=1e-12)


def spin(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    time: NDArray[np.float64] = 4e-3 * np.arange(50.0)
    windows, starts = np.array([-1]), np.zeros((1, 2))
    return simulate_record(vector, time, np.ones(50), np.zeros(0), windows, starts)


def test_frozen_parameters_are_read_anew_for_every_simulation() -> None:
    vector = s.neutral_vector()
    before = vector.copy()
    first = spin(vector)
    vector[s.VISCOUS] = 20.0
    second = spin(vector)
    vector[s.VISCOUS] = 0.0
    assert np.array_equal(spin(vector), first)
    assert not np.array_equal(first, second)
    assert np.array_equal(vector, before)


def test_outside_compiled_code_parameters_stay_an_array() -> None:
    vector = s.neutral_vector()
    assert freeze(vector) is vector
