"""Error and cost of the ways to compute speed from the potentiometer: prints the tables of docs/speed.md.

Run `python benchmarks/speed.py`. The truth is known because the signals are made here: a joint with a lag of
0.56 s moved by references of a paper-like campaign, seen through a ten-turn potentiometer of 65536 counts
with 3 counts rms of noise. `python benchmarks/speed.py --emulator` takes positions and true speeds from the
emulated controller's physics instead.
"""

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.signal import firwin, lfilter, oaconvolve, savgol_coeffs

from daq.recording.resample import extend_ends
from daq.speed.filters import CausalSpeedFilter, speed_from_position_zero_phase
from daq.speed.options import SpeedMethod, SpeedOptions

FloatArray = npt.NDArray[np.float64]
Method = Callable[[FloatArray, float], FloatArray]

SAMPLE_TIME_S = 4e-4
RAD_PER_COUNT = 20.0 * np.pi / 65536.0
NOISE_COUNTS = 3.0
LAG_S = 0.56
BANDWIDTHS_HZ = (2.0, 5.0, 10.0, 20.0, 40.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """What moved: position as the controller counts it and the true speed, each of shape (n,)."""

    position_rad: FloatArray
    speed_rad_s: FloatArray


def synthetic_motions(duration_s: float = 100.0) -> dict[str, Motion]:
    """Return motions of about 1 rad/s: smooth, with corners, broadband, and with ripple and stick-slip."""
    time_s = np.arange(0.0, duration_s, SAMPLE_TIME_S)
    rng = np.random.default_rng(1)
    levels = np.repeat(rng.choice([-2.0, 2.0], size=int(duration_s / 0.1) + 1), round(0.1 / SAMPLE_TIME_S))
    trapezoid = np.clip(3.0 * np.sin(2.0 * np.pi * time_s / 50.0), -1.0, 1.0)
    sine = np.sin(2.0 * np.pi * time_s / 10.0)
    stuck = np.where(np.abs(sine) > 0.15, sine - 0.15 * np.sign(sine), 0.0)
    ripple = 0.05 * np.sin(6.0 * np.cumsum(stuck) * SAMPLE_TIME_S)
    return {
        "sine 0.1 Hz": _motion(_lagged(sine), rng),
        "trapezoid 50 s": _motion(_lagged(trapezoid), rng),
        "PRBS 0.1 s": _motion(_lagged(levels[: len(time_s)]), rng),
        "stick and ripple": _motion(stuck + ripple * (stuck != 0.0), rng),
    }


def emulated_motions() -> dict[str, Motion]:
    """Return motions of the emulated joint, computed by a process of its own."""
    script = Path(__file__).with_name("speed_truth.py")
    with TemporaryDirectory() as folder:
        command = [sys.executable, str(script), folder]
        answer = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
        return {name: _read_motion(path) for name, path in json.loads(answer.stdout).items()}


def _read_motion(path: str) -> Motion:
    with np.load(path) as arrays:
        return Motion(
            position_rad=(arrays["position_counts"] - 32768.0) * RAD_PER_COUNT,
            speed_rad_s=arrays["speed_rad_s"],
        )


def _lagged(reference: FloatArray) -> FloatArray:
    pole = np.exp(-SAMPLE_TIME_S / LAG_S)
    return np.asarray(lfilter([1.0 - pole], [1.0, -pole], reference))


def _motion(speed: FloatArray, rng: np.random.Generator) -> Motion:
    steps = 0.5 * (speed[1:] + speed[:-1]) * SAMPLE_TIME_S
    position = np.concatenate([[0.0], np.cumsum(steps)])
    counts = np.rint(position / RAD_PER_COUNT + rng.normal(scale=NOISE_COUNTS, size=len(position)))
    return Motion(position_rad=counts * RAD_PER_COUNT, speed_rad_s=speed)


def _ours(method: SpeedMethod) -> Method:
    def zero_phase(position: FloatArray, bandwidth_hz: float) -> FloatArray:
        options = SpeedOptions(method=method, bandwidth_hz=bandwidth_hz)
        return speed_from_position_zero_phase(position, SAMPLE_TIME_S, options)

    return zero_phase


def _ours_causal(method: SpeedMethod) -> Method:
    def causal(position: FloatArray, bandwidth_hz: float) -> FloatArray:
        speed_filter = CausalSpeedFilter(
            SAMPLE_TIME_S, SpeedOptions(method=method, bandwidth_hz=bandwidth_hz)
        )
        return speed_filter.step(speed_filter.init(), position)

    return causal


def windowed_fir(position: FloatArray, bandwidth_hz: float) -> FloatArray:
    """Differentiate by central differences behind a Hamming-windowed low-pass, -6 dB at 1.129 bandwidths."""
    half = round(1.55 / (bandwidth_hz * SAMPLE_TIME_S))
    taps = firwin(2 * half + 1, 1.129 * bandwidth_hz, fs=1.0 / SAMPLE_TIME_S)
    speed = np.gradient(extend_ends(position, half, fitted=half // 2), SAMPLE_TIME_S)
    return np.asarray(oaconvolve(speed, taps, mode="valid"))


def central_difference(position: FloatArray, bandwidth_hz: float) -> FloatArray:
    """Difference of two samples so far apart that the gain falls to 0.707 at the bandwidth."""
    half = max(1, round(0.2215 / (bandwidth_hz * SAMPLE_TIME_S)))
    padded = np.pad(position, half, mode="edge")
    return (padded[2 * half :] - padded[: -2 * half]) / (2 * half * SAMPLE_TIME_S)


def end_point_savitzky_golay(position: FloatArray, bandwidth_hz: float) -> FloatArray:
    """Slope of a parabola through the last window, at its last sample."""
    window = 2 * round(0.65 / (bandwidth_hz * SAMPLE_TIME_S)) + 1
    taps = savgol_coeffs(window, 2, deriv=1, delta=SAMPLE_TIME_S, pos=window - 1)
    return np.asarray(oaconvolve(position - position[0], taps)[: len(position)])


ZERO_PHASE: Mapping[str, Method] = {
    "Kalman smoother": _ours(SpeedMethod.KALMAN),
    "Savitzky-Golay": _ours(SpeedMethod.SAVITZKY_GOLAY),
    "windowed FIR": windowed_fir,
    "difference": central_difference,
}
CAUSAL: Mapping[str, Method] = {
    "Kalman filter": _ours_causal(SpeedMethod.KALMAN),
    "Savitzky-Golay, centre": _ours_causal(SpeedMethod.SAVITZKY_GOLAY),
    "Savitzky-Golay, end": end_point_savitzky_golay,
}


def print_errors(title: str, methods: Mapping[str, Method], motions: Mapping[str, Motion]) -> None:
    """Print one table: rms error in mrad/s, methods and bandwidths down, motions across."""
    print(f"\n{title}: rms error against the true speed, mrad/s (1 s at both ends left out)\n")
    print(f"| method | bandwidth Hz | {' | '.join(motions)} |")
    print("|---|---|" + "---|" * len(motions))
    settled = round(1.0 / SAMPLE_TIME_S)
    for name, method in methods.items():
        for bandwidth_hz in BANDWIDTHS_HZ:
            errors = [
                (method(motion.position_rad, bandwidth_hz) - motion.speed_rad_s)[settled:-settled]
                for motion in motions.values()
            ]
            cells = " | ".join(f"{1e3 * float(np.sqrt(np.mean(error**2))):.1f}" for error in errors)
            print(f"| {name} | {bandwidth_hz:g} | {cells} |")


def print_end_errors(motions: Mapping[str, Motion], runs_s: float = 1.0) -> None:
    """Print what the ends of short runs cost: as a recording with a hole every second would be cut."""
    print(f"\nZero-phase, 10 Hz, runs of {runs_s:g} s: rms error, mrad/s, by distance from the nearest end\n")
    print("| method | 0 to 10 ms | 10 to 50 ms | 50 to 100 ms | beyond |\n|---|---|---|---|---|")
    samples = round(runs_s / SAMPLE_TIME_S)
    distance_s = np.minimum(np.arange(samples), np.arange(samples)[::-1]) * SAMPLE_TIME_S
    edges = [0.0, 0.01, 0.05, 0.1, np.inf]
    for name, method in ZERO_PHASE.items():
        squares = np.mean([_run_errors(method, motion, samples) for motion in motions.values()], axis=0)
        cells = [
            f"{1e3 * float(np.sqrt(np.mean(squares[(distance_s >= low) & (distance_s < high)]))):.1f}"
            for low, high in pairwise(edges)
        ]
        print(f"| {name} | {' | '.join(cells)} |")


def _run_errors(method: Method, motion: Motion, samples: int) -> FloatArray:
    runs = len(motion.position_rad) // samples
    squares = np.zeros(samples)
    for k in range(runs):
        run = slice(k * samples, (k + 1) * samples)
        squares += (method(motion.position_rad[run], 10.0) - motion.speed_rad_s[run]) ** 2
    return squares / runs


def print_costs() -> None:
    """Print the time that 2.5 million samples take, best of three."""
    position = np.cumsum(np.random.default_rng(2).normal(size=2_500_000)) * 1e-4
    print("\nCost of 2.5 million samples at 10 Hz, s (best of three)\n\n| method | s |\n|---|---|")
    costs: dict[str, Any] = {**ZERO_PHASE, **CAUSAL}
    for name, method in costs.items():
        print(f"| {name} | {min(_seconds(method, position) for _ in range(3)):.3f} |")


def _seconds(method: Method, position: FloatArray) -> float:
    start = time.perf_counter()
    method(position, 10.0)
    return time.perf_counter() - start


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--emulator", action="store_true", help="true speeds of the emulated joint")
    motions = emulated_motions() if parser.parse_args().emulator else synthetic_motions()
    print_errors("Zero-phase", ZERO_PHASE, motions)
    print_errors("Causal", CAUSAL, motions)
    print_end_errors(motions)
    print_costs()


if __name__ == "__main__":
    main()
