"""The compiled joint against closed forms."""

import numpy as np
import pytest
from numpy.typing import NDArray

from discrepancy.effects.table import EFFECTS
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.joint import simulate_record

FloatArray = NDArray[np.float64]


def joint(**changes: float) -> FloatArray:
    vector = s.neutral_vector()
    vector[s.INERTIA], vector[s.VISCOUS] = 0.5, 0.9
    for name, value in changes.items():
        vector[getattr(s, name)] = value
    return vector


def run(vector: FloatArray, current: FloatArray, step: float = 1e-3, speed: float = 0.0) -> FloatArray:
    time = np.arange(current.size, dtype=np.float64) * step
    return simulate_record(vector, time, current, np.empty(0), np.array([-1]), np.array([[speed, 0.0]]))


def test_step_response_is_the_exponential() -> None:
    speed = run(joint(), np.ones(2000))[0]
    exact = (1.0 - np.exp(-np.arange(2000) * 1e-3 * 0.9 / 0.5)) / 0.9
    # Second order at 1 ms of a 0.56 s time constant: (h/tau)^2 / 12 is 3e-7.
    assert np.max(np.abs(speed - exact)) < 1e-6


def test_dry_friction_holds_a_joint_below_its_level() -> None:
    speed = run(joint(COULOMB=0.2), 0.199 * np.sin(np.arange(3000) * 0.01))[0]
    assert np.all(speed == 0.0)


def test_dry_friction_stops_a_coasting_joint_at_the_exact_time() -> None:
    speed = run(joint(COULOMB=0.3), np.zeros(2000), speed=1.0)[0]
    exact_stop = 0.5 / 0.9 * np.log1p(0.9 / 0.3)
    # The stop lies inside one step of 1 ms.
    assert abs(np.flatnonzero(speed == 0.0)[0] * 1e-3 - exact_stop) <= 1e-3


def test_halving_the_step_changes_nothing_material() -> None:
    time = np.arange(4000) * 2e-3
    current = np.sin(2.0 * time) + 0.3 * np.sin(11.0 * time)
    vector = joint(COULOMB=0.15, STRIBECK_EXTRA=0.1, STRIBECK_SPEED=0.1)
    coarse = run(vector, current, 2e-3)[0]
    vector[s.MAX_STEP] = 1e-3
    fine = run(vector, current, 2e-3)[0]
    # A thousandth of the speed's size: far below the noise of any rig.
    assert np.sqrt(np.mean((coarse - fine) ** 2)) < 1e-3 * np.std(fine)


def test_general_and_plain_path_agree() -> None:
    current = np.sin(np.arange(5000) * 0.01)
    plain = run(joint(COULOMB=0.1, QUADRATIC=0.1), current)
    general = run(joint(COULOMB=0.1, QUADRATIC=0.1, STOP_STIFFNESS=1.0), current)
    np.testing.assert_allclose(general[0], plain[0], atol=1e-9)


def test_delay_shifts_the_motion() -> None:
    current = np.sin(np.arange(4000) * 0.01)
    late = run(joint(DELAY=0.05), current)[0]
    np.testing.assert_allclose(late[1050:], run(joint(), current)[0][1000:-50], atol=1e-3)


@pytest.mark.parametrize("name", sorted(EFFECTS))
def test_neutral_parameters_switch_an_effect_off(name: str) -> None:
    neutral = s.neutral_vector()
    assert all(np.isfinite(neutral[p.slot]) for p in EFFECTS[name].parameters)
    assert {p.slot for p in EFFECTS[name].parameters} <= set(range(s.N_SLOTS))


def test_catalogue_holds_the_agreed_26_ids() -> None:
    assert len(EFFECTS) == 26
    assert {other for effect in EFFECTS.values() for other in effect.confused_with} <= set(EFFECTS)
