"""Measured files as users send them: a joint of the first order, with or without dry friction, as CSV."""

import io
from typing import Any

import httpx
import numpy as np
import numpy.typing as npt

SAMPLE_TIME_S = 0.01
MODEL = """\
name: bench
outputs: [speed_rad_s]
input_hold: hold
parameters:
  inertia: {value: 0.5, unit: kg m^2, fixed: true}
  viscous_friction: {value: 0.9090909, unit: N m s/rad}
  torque_constant: {value: 1.0, unit: N m/A}
"""
FloatArray = npt.NDArray[np.float64]
Json = dict[str, Any]  # JSON values


def measured_columns(seed: int = 1, n: int = 3000) -> dict[str, FloatArray]:
    """Return time, current and speed of a joint with gain 1.1 and time constant 0.55 s, the current held."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(n, dtype=np.float64) * SAMPLE_TIME_S
    waves = [0.2 * np.sin(2 * np.pi * (k * time_s / 20.0 + rng.random())) for k in (1, 2, 3, 5, 8, 13, 21)]
    current: FloatArray = np.sum(waves, axis=0)
    pole, speed = np.exp(-SAMPLE_TIME_S / 0.55), np.zeros(n)
    for k in range(1, n):
        speed[k] = pole * speed[k - 1] + 1.1 * (1.0 - pole) * current[k - 1]
    return {"time_s": time_s, "current_A": current, "speed_rad_s": speed + 1e-4 * rng.standard_normal(n)}


def as_csv(columns: dict[str, FloatArray]) -> bytes:
    """Return columns as a CSV file that reads back to the same numbers."""
    text = io.StringIO()
    np.savetxt(
        text, np.column_stack(list(columns.values())), "%.17g", ",", header=",".join(columns), comments=""
    )
    return text.getvalue().encode()


def upload(client: httpx.Client, name: str = "measured", content: bytes | None = None, **params: Any) -> Json:
    """Upload a measured CSV file and return what the service says of it."""
    octets = as_csv(measured_columns()) if content is None else content
    answer = client.post("/api/v1/recordings", params={"file": f"{name}.csv", **params}, content=octets)
    assert answer.status_code == 201, answer.text
    made: Json = answer.json()
    return made
