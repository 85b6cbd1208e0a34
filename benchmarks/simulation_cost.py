"""What a step of the grey-box joint's simulation costs: `python -m benchmarks.simulation_cost [--steps N]`.

The base joint and the joint with each effect of the catalogue, at the first of its starting values, run through a rich
current at the sampling period that needs one sub-step a sample, so that a sample is a step. Printed is processor time a
step: the least of several runs, since other work on the machine only adds to it.
"""

import argparse
import time

import numpy as np
from numpy.typing import NDArray

from discrepancy.effects.spec import Ranges
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.parameters import write_start
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.joint import simulate_record

FloatArray = NDArray[np.float64]

STEP_S = 4e-4
REPEATS = 5
RANGES = Ranges(
    torque=0.5, speed=1.0, current=1.0, duration=40.0, step=STEP_S, low=-2.0, high=2.0, inertia=0.5, rate=1.8,
    waves={},
)  # fmt: skip
TOGETHER = ("stribeck_friction", "belt_compliance", "gravity_unbalance", "torque_ripple")


def joint(*names: str) -> FloatArray:
    """Return the parameters of a joint with these effects, shape (N_SLOTS,)."""
    vector = s.neutral_vector()
    vector[s.INERTIA], vector[s.VISCOUS] = RANGES.inertia, RANGES.rate * RANGES.inertia
    vector[s.MAX_STEP] = STEP_S
    for name in names:
        vector = write_start(vector, EFFECTS[name], EFFECTS[name].starts(RANGES)[0], ())
    return vector


def cost(vector: FloatArray, steps: int) -> float:
    """Return the processor time of a step, ns."""
    t = np.arange(steps, dtype=np.float64) * STEP_S
    u = np.sin(2.0 * np.pi * 1.3 * t) + 0.5 * np.sin(2.0 * np.pi * 7.1 * t)
    rest = np.empty(0), np.array([-1]), np.zeros((1, 2))
    simulate_record(vector, t, u, *rest)
    found = []
    for _ in range(REPEATS):
        begun = time.process_time()
        simulate_record(vector, t, u, *rest)
        found.append(time.process_time() - begun)
    return 1e9 * min(found) / steps


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=1_000_000)
    steps: int = parser.parse_args().steps
    print("| joint | ns a step |\n|---|---|")
    print(f"| base | {cost(joint(), steps):.0f} |")
    for name in EFFECTS:
        print(f"| {name} | {cost(joint(name), steps):.0f} |")
    print(f"| {', '.join(TOGETHER)} | {cost(joint(*TOGETHER), steps):.0f} |")


if __name__ == "__main__":
    main()
