"""Reference currents of the blind cases, A at 2.5 kHz: rich excitation, the paper's sine, slow ones for stops."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

TICK_S = 4e-4
DURATION_S = 40.0
LIMIT_A = 1.4
_STEP_S = 0.2


def _time() -> FloatArray:
    return np.arange(round(DURATION_S / TICK_S), dtype=np.float64) * TICK_S


def _fade(time: FloatArray) -> FloatArray:
    return np.minimum(1.0, time / 0.5)


def rich(generator: np.random.Generator) -> FloatArray:
    """Return nine sines of 0.05 to 8 Hz, a random step sequence, and one slow swing over about 3.5 rad.

    Every effect but end stops shows in it. Without the swing the joint would stay within a radian or two, where a
    weight on a four times slower joint is hardly more than a spring.
    """
    time = _time()
    frequencies = np.exp(generator.uniform(np.log(0.05), np.log(8.0), 9))
    phases = generator.uniform(0, 2 * np.pi, 9)
    wave = np.sin(2 * np.pi * np.outer(frequencies, time) + phases[:, None]).sum(axis=0)
    steps = generator.choice([-1.0, 1.0], size=round(DURATION_S / _STEP_S) + 1)
    steps = np.repeat(steps, round(_STEP_S / TICK_S))[: time.size]
    swing = 0.25 * np.sin(2 * np.pi * time / DURATION_S + generator.uniform(0, 2 * np.pi))
    return np.asarray(np.clip(0.22 * wave + 0.25 * steps + swing, -LIMIT_A, LIMIT_A) * _fade(time))


def sweeping(generator: np.random.Generator) -> FloatArray:
    """Return rich excitation at 0.6 of its size on a slow sine that carries the joint over about five radians."""
    time = _time()
    slow = 0.8 * np.sin(2 * np.pi * 0.075 * time + generator.uniform(0, 2 * np.pi))
    return np.asarray(np.clip(0.6 * rich(generator) + slow * _fade(time), -LIMIT_A, LIMIT_A))


def sine() -> FloatArray:
    """Return the paper's sine: 0.8 A, period 10 s."""
    time = _time()
    return np.asarray(0.8 * np.sin(2 * np.pi * time / 10.0) * _fade(time))


def wide_sine() -> FloatArray:
    """Return a sine of the paper's range that reaches every end stop drawn: 1 A, period 20 s, 3.3 rad to each side."""
    time = _time()
    return np.asarray(np.sin(2 * np.pi * time / 20.0) * _fade(time))
