"""Plants and records shared by the estimators' tests."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from estimators.dataset import Dataset
from estimators.kernels.simulation import simulate_difference_equation
from estimators.regressors import Regression, build_regression
from estimators.structure import ModelStructure

Vector = NDArray[np.float64]
SAMPLE_TIME_S = 0.2
# A well damped second-order plant: poles 0.75 +- 0.37j.
PLANT_A = (-1.5, 0.7)
PLANT_B = (1.0, 0.5)


@pytest.fixture
def simulate() -> Callable[..., Vector]:
    """Return a function that simulates A y = B u(k - delay) + e from rest."""

    def run(
        u: Vector,
        a: tuple[float, ...] = PLANT_A,
        b: tuple[float, ...] = PLANT_B,
        delay: int = 1,
        equation_noise: Vector | None = None,
    ) -> Vector:
        y = np.empty_like(u)
        simulate_difference_equation(np.array(a), np.array(b), delay, u, 0, y)
        if equation_noise is not None:
            shaped = np.empty_like(u)
            simulate_difference_equation(np.array(a), np.ones(1), 0, equation_noise, 0, shaped)
            y += shaped
        return y

    return run


@pytest.fixture
def noisy_record(simulate: Callable[..., Vector]) -> Dataset:
    """Return 400 samples of the plant with white equation noise of standard deviation 0.1."""
    rng = np.random.default_rng(1)
    u = rng.normal(size=400)
    return Dataset(u=u, y=simulate(u, equation_noise=0.1 * rng.normal(size=400)), sample_time_s=SAMPLE_TIME_S)


@pytest.fixture
def regression(noisy_record: Dataset) -> Regression:
    """Return the second-order regression of the noisy record."""
    return build_regression(noisy_record, ModelStructure(na=2, nb=2))


@pytest.fixture
def joint_records() -> tuple[Dataset, Dataset]:
    """Return a sine (training) and a trapezoid (test) record of a joint like the paper's.

    First order, gain 1, tau = J / B = 5e-4 / 5.65e-4 s of the paper's Table 1, 5006 samples at 0.2 s, current
    held between samples, 1 % noise on the speed.
    """
    rng = np.random.default_rng(7)
    t = SAMPLE_TIME_S * np.arange(5006)
    sine = np.sin(2 * np.pi * t / 50)
    trapezoid = np.clip(1.5 * (4 * np.abs((t / 40) % 1 - 0.5) - 1), -1, 1)
    decay = float(np.exp(-SAMPLE_TIME_S / (5e-4 / 5.65e-4)))
    records = []
    for u in (sine, trapezoid):
        speed = np.empty_like(u)
        simulate_difference_equation(np.array([-decay]), np.array([1 - decay]), 1, u, 0, speed)
        noise = 0.01 * speed.std() * rng.normal(size=u.size)
        records.append(Dataset(u=u, y=speed + noise, sample_time_s=SAMPLE_TIME_S))
    return records[0], records[1]
