"""The loop without presliding springs and the plain one say what the loop with springs says."""

import numpy as np
import pytest

from discrepancy.effects.spec import Ranges
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.parameters import write_start
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.joint import simulate_record

RANGES = Ranges(
    torque=0.05, speed=30.0, current=2.0, duration=4.0, step=2e-3, low=-3.0, high=3.0, inertia=5e-4, rate=1.0
)
WITHOUT_SPRINGS = sorted(set(EFFECTS) - {"presliding_hysteresis"})


@pytest.mark.parametrize("name", WITHOUT_SPRINGS)
def test_a_joint_without_presliding_moves_as_beside_a_spring_of_no_strength(name: str) -> None:
    rng = np.random.default_rng(5)
    time = np.linspace(0.0, 4.0, 1001)
    current = np.interp(time, np.arange(0.0, 4.2, 0.1), rng.normal(size=42))
    vector = s.neutral_vector()
    vector[s.INERTIA], vector[s.VISCOUS], vector[s.TORQUE_CONSTANT] = 5e-4, 5e-4, 0.05
    vector[s.INPUT_SHIFT] = 1e-3
    vector = write_start(vector, EFFECTS[name], EFFECTS[name].starts(RANGES)[0], ())
    general = vector.copy()
    general[s.PRESLIDING_LEVEL], general[s.PRESLIDING_STIFFNESS] = 1e-15, 1e-15
    windows, starts = np.array([-1, 300, -601]), np.array([[0.5, 0.1], [0.3, 0.2], [0.0, 0.3]])
    alone = simulate_record(vector, time, current, np.sin(time), windows, starts)
    beside = simulate_record(general, time, current, np.sin(time), windows, starts)
    # Without dry friction the loop does not split the sub-step in which the speed changes its sign.
    assert np.max(np.abs(alone - beside) / np.max(np.abs(beside), axis=1, keepdims=True)) < 1e-4


@pytest.mark.parametrize("shape", [1.0, 2.0, 3.0])
@pytest.mark.parametrize("weight", [0.02, -0.035])
def test_a_joint_that_hangs_on_its_presliding_springs_stays_where_it_is(shape: float, weight: float) -> None:
    time = np.linspace(0.0, 2.0, 501)
    vector = s.neutral_vector()
    vector[s.INERTIA], vector[s.VISCOUS], vector[s.LOAD_OFFSET] = 5e-4, 5e-4, weight
    vector[s.PRESLIDING_LEVEL], vector[s.PRESLIDING_STIFFNESS], vector[s.PRESLIDING_SHAPE] = 0.05, 2.0, shape
    windows, starts = np.array([-1]), np.array([[0.0, 0.3]])
    speed, angle, _ = simulate_record(vector, time, np.zeros(501), np.empty(0), windows, starts)
    assert np.max(np.abs(speed)) < 1e-6
    assert angle == pytest.approx(np.full(501, 0.3), abs=1e-6)
