"""Noise that a case adds to the emulator's own: white, coloured, or nothing but rounding."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from benchmarks.blind.conditions import Noise
from benchmarks.blind.excitation import TICK_S

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class AddedNoise:
    """Noise of one case, new in every record.

    Attributes:
        rms: rad/s.
        pole: of first-order noise at 2.5 kHz; 0 is white.
        step: the noise-free speed is rounded to multiples of it, rad/s; 0 leaves the speed as it was derived.
    """

    rms: float = 0.0
    pole: float = 0.0
    step: float = 0.0

    @property
    def text(self) -> str:
        """The noise in words."""
        return f"rms {self.rms:.4g} rad/s, pole {self.pole:.5f}, rounding {self.step:.4g} rad/s"

    def add(self, speed: FloatArray, clean: FloatArray, generator: np.random.Generator) -> FloatArray:
        """Return the speed as recorded, shape (n,), of the derived and of the noise-free one."""
        if self.step > 0.0:
            return np.asarray(np.round(clean / self.step) * self.step)
        if self.rms == 0.0:
            return speed
        drive = np.sqrt(1.0 - self.pole**2) * generator.standard_normal(speed.size)
        start = [self.pole * generator.standard_normal()]
        noise, _ = lfilter([1.0], [1.0, -self.pole], drive, zi=start)
        return np.asarray(speed + self.rms * noise)


def draw_noise(kind: Noise, generator: np.random.Generator) -> AddedNoise:
    """Draw what a case adds: 0.01 to 0.05 rad/s rms; memory of 5 to 500 ms; half of the roundings by the converter."""
    if kind is Noise.WHITE:
        return AddedNoise(rms=float(generator.uniform(0.01, 0.05)))
    if kind is Noise.COLOURED:
        memory = float(np.exp(generator.uniform(np.log(5e-3), np.log(0.5))))
        return AddedNoise(rms=float(generator.uniform(0.01, 0.05)), pole=float(np.exp(-TICK_S / memory)))
    if kind is Noise.QUANTISED and generator.integers(2):
        return AddedNoise(step=float(generator.uniform(0.005, 0.05)))
    return AddedNoise()
