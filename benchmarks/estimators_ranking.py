"""Does the paper's ranking of RLS, ERLS and RLS-KF hold? 48 simulated joints, every figure of merit.

Run with `python -m benchmarks.estimators_ranking`. Plant: tau dw/dt = K i - w - wc sign(w), which sticks at zero
speed; 10 ms steps, sampled at 0.2 s for 1001 s; a sine trains, a trapezoid tests, noise on the speed. Scenarios:
tau 0.885 s (J / B of the paper's Table 1) or 3 s; Coulomb friction 0 or 8 % of full torque; period 25 to 200 s;
noise 0.2, 1 or 10 % of the speed's standard deviation.
"""

import itertools

import numpy as np
from numpy.typing import NDArray

from estimators.dataset import Dataset
from estimators.identify import identify
from estimators.result import IdentificationResult, Mode, Phase
from estimators.settings import IdentifyOptions

Array = NDArray[np.float64]
SAMPLES, SAMPLE_TIME_S, SUBSTEPS = 5006, 0.2, 20
SCENARIOS = list(itertools.product((0.885, 3.0), (0.0, 0.08), (25.0, 50.0, 100.0, 200.0), (0.002, 0.01, 0.1)))
METHODS = ("rls", "erls", "rls_kf", "rls_kf_literal", "rls_kf_ml")


def main() -> None:
    """Print medians and how often RLS-KF is ranked first."""
    for gain in (1.0, 100.0):
        train, test = simulate_joints(gain)
        for near_zero in (False, True):
            options = IdentifyOptions(methods=METHODS, start_near_zero=near_zero, select_order=False)
            results = [identify(*pair, options) for pair in zip(train, test, strict=True)]
            start = "started near zero" if near_zero else "started with a large P"
            print(f"\nK = {gain:g}, {start}: median adjusted R2 of {len(results)} scenarios, test record")
            print_table(results)


def simulate_joints(gain: float) -> tuple[list[Dataset], list[Dataset]]:
    """Return training and test records of all scenarios, simulated side by side."""
    tau, coulomb, period, noise = (np.array(column) for column in zip(*SCENARIOS, strict=True))
    t = SAMPLE_TIME_S * np.arange(SAMPLES)[:, None]
    sine = np.sin(2 * np.pi * t / period)
    trapezoid = np.clip(1.5 * (4 * np.abs((t / period) % 1 - 0.5) - 1), -1, 1)
    rng = np.random.default_rng(2021)
    records = []
    for u in (sine, trapezoid):
        speed = simulate_speed(gain, tau, coulomb, u)
        speed += noise * speed.std(axis=0) * rng.normal(size=speed.shape)
        records.append(
            [Dataset(u=u[:, i], y=speed[:, i], sample_time_s=SAMPLE_TIME_S) for i in range(tau.size)]
        )
    return records[0], records[1]


def simulate_speed(gain: float, tau: Array, coulomb: Array, u: Array) -> Array:
    """Return the speed at the samples, shape (samples, scenarios), with the input held between them."""
    decay = np.exp(-SAMPLE_TIME_S / SUBSTEPS / tau)
    speed, out = np.zeros(tau.size), np.empty_like(u)
    friction = gain * coulomb
    for k in range(u.shape[0]):
        out[k] = speed
        for _ in range(SUBSTEPS):
            drive = gain * u[k]
            direction = np.where(speed != 0, np.sign(speed), np.sign(drive))
            stuck = (speed == 0) & (np.abs(drive) <= friction)
            moved = decay * speed + (1 - decay) * (drive - friction * direction)
            reversed_ = (speed != 0) & (moved * speed < 0)
            speed = np.where(stuck | reversed_, 0.0, moved)
    return out


def print_table(results: list[IdentificationResult]) -> None:
    """Print one line per estimator, then the yardstick and the shares."""
    modes = list(Mode)
    print(f"{'':18}" + "".join(f"{mode.value:>18}" for mode in modes) + f"{'not simulable':>15}")
    for name in METHODS:
        medians = [np.nanmedian([read_r2(result, name, mode) for result in results]) for mode in modes]
        unable = np.mean([not result.methods[name].model.simulable for result in results])
        print(f"{name:18}" + "".join(f"{value:18.5f}" for value in medians) + f"{unable:14.0%}")
    trivial = np.median([result.trivial[Phase.TEST].r2_adjusted for result in results])
    print(f"{'y(k-1)':18}{trivial:18.5f}")
    shares = [np.mean([ranks_kf_first(result, mode) for result in results]) for mode in modes]
    print(f"{'RLS-KF first of 3':18}" + "".join(f"{share:18.0%}" for share in shares))


def read_r2(result: IdentificationResult, name: str, mode: Mode) -> float:
    """Return the adjusted R2 on the test record; a diverged free run counts as minus infinity."""
    value = result.methods[name].scores[Phase.TEST][mode].r2_adjusted
    return value if np.isfinite(value) else -np.inf


def ranks_kf_first(result: IdentificationResult, mode: Mode) -> bool:
    """Say whether RLS-KF beats RLS and ERLS, as the paper has it."""
    kf = read_r2(result, "rls_kf", mode)
    return kf > read_r2(result, "rls", mode) and kf > read_r2(result, "erls", mode)


if __name__ == "__main__":
    main()
