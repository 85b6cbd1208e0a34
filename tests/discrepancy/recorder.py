"""Recordings of a joint simulated by the package's own kernel."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from daq.recording.recording import Recording, recording_from_columns
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.joint import simulate_record

FloatArray = NDArray[np.float64]
STEP_S = 2e-3


def excite(seed: int, n: int, step_s: float) -> FloatArray:
    """Return a rich current: sines and random steps."""
    rng = np.random.default_rng(seed)
    time = np.arange(n) * step_s
    frequencies = np.exp(rng.uniform(np.log(0.1), np.log(6.0), 7))
    wave = np.sin(2 * np.pi * np.outer(frequencies, time) + rng.uniform(0, 6.28, (7, 1))).sum(axis=0)
    steps = np.repeat(rng.choice([-1.0, 1.0], n // 100 + 1), 100)[:n]
    return np.asarray(0.3 * wave + 0.3 * steps)


def make_recording(
    changes: Mapping[int, float],
    seed: int,
    *,
    noise: float = 0.01,
    input_seed: int = 0,
    played: FloatArray | None = None,
) -> Recording:
    """Simulate 16 s at 2 ms, or as long as the current that was played, and add white speed noise."""
    current = excite(input_seed, 8000, STEP_S) if played is None else played
    n, step = current.size, STEP_S
    vector = s.neutral_vector()
    vector[s.INERTIA], vector[s.VISCOUS] = 0.5, 0.9
    for slot, value in changes.items():
        vector[slot] = value
    time = np.arange(n, dtype=np.float64) * step
    out = simulate_record(vector, time, current, np.empty(0), np.array([-1]), np.zeros((1, 2)))
    rng = np.random.default_rng(seed)
    columns = {
        "time_s": time, "current_A": current, "speed_rad_s": out[0] + rng.normal(0.0, noise, n), "position_rad": out[1],
    }  # fmt: skip
    return recording_from_columns(columns, sample_time_s=step)
