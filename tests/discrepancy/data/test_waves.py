"""The wave number at which a weak torque repeats over the angle is found beneath the noise of the speed."""

import numpy as np
import pytest
from numpy.typing import NDArray

from discrepancy.data.ranges import find_waves
from discrepancy.data.series import POSITION, SPEED, Channel, Series
from discrepancy.simulation import slots as s

STEP = 4e-3
WAVE = 5.4


def _vector() -> NDArray[np.float64]:
    vector = s.neutral_vector()
    vector[s.INERTIA], vector[s.VISCOUS], vector[s.TORQUE_CONSTANT] = 0.5, 0.9, 1.0
    return vector


def _moved(torque: float, wave: float) -> list[NDArray[np.float64]]:
    """Return time, current, speed and angle of a joint that coasts through a torque that repeats over its angle."""
    time = STEP * np.arange(10_000)
    current = 0.8 * np.sin(0.9 * time) + 0.5 * np.sin(2.3 * time)
    speed, angle = np.zeros(time.size), np.zeros(time.size)
    for i in range(1, time.size):
        force = current[i - 1] - 0.9 * speed[i - 1] - torque * np.sin(wave * angle[i - 1] + 0.4)
        speed[i] = speed[i - 1] + STEP * force / 0.5
        angle[i] = angle[i - 1] + STEP * speed[i]
    return [np.asarray(one, dtype=np.float64) for one in (time, current, speed, angle)]


@pytest.mark.parametrize("row", [SPEED, POSITION])
def test_a_slow_wave_is_not_hidden_behind_the_noise_of_fast_ones(row: int) -> None:
    time, current, bare, bare_angle = _moved(0.0, WAVE)
    _, _, speed, angle = _moved(0.008, WAVE)
    noise = np.random.default_rng(5).normal(0.0, 5e-3 if row == SPEED else 5e-5, time.size)
    measured, residual = (
        (speed, speed - bare + noise) if row == SPEED else (angle, angle - bare_angle + noise)
    )
    channel = Channel(name="output", row=row, values=measured, weight=np.ones(time.size))
    series = Series(
        label="ripple", step=STEP, original_step=STEP, time_s=time, input=current, angle=angle,
        channels=(channel,), windows=np.array([-1]), starts=np.zeros((1, 2)),
    )  # fmt: skip
    found = find_waves([series], [residual], _vector())
    assert abs(found["torque_high"][0] - WAVE) < 2.0 * np.pi / np.ptp(angle)
