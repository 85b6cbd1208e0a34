"""CPU time of the emulated rig for one 1001 s experiment: 2.5 million ticks, 50 million sub-steps of 20 us.

Run: python -m benchmarks.emulator_physics
"""

import os
import time

import numpy as np

from mock_dsp.control.parameters import TICK_S, FastLoopParameters
from mock_dsp.physics.rig import EmulatedRig
from mock_dsp.scenario.effects import EFFECTS
from mock_dsp.scenario.schema import Effect, Scenario

TICKS = 2_502_500
BLOCK = 2500
SUBSTEPS = 20
CASES = {
    "nothing hidden": (),
    "coulomb_friction": ("coulomb_friction",),
    "stribeck_friction": ("stribeck_friction",),
    "belt_compliance": ("belt_compliance",),
    "every effect at once": tuple(EFFECTS),
}


def measure(effects: tuple[str, ...]) -> float:
    """Return the CPU time of one experiment in blocks of one second, s."""
    scenario = Scenario(name="benchmark", effects=tuple(Effect(id=effect) for effect in effects))
    rig = EmulatedRig.from_scenario(scenario)
    # A wide travel: no trip ends the run, whatever is hidden.
    rig.set_parameters(
        FastLoopParameters(pwm_on=True, centring_on=True, travel_min_rad=-40.0, travel_max_rad=40.0)
    )
    rig.run(np.zeros(250))
    reference = 0.8 * np.sin(2.0 * np.pi * np.arange(TICKS) * TICK_S / 20.0)
    start = time.process_time()
    for first in range(0, TICKS, BLOCK):
        rig.run(reference[first : first + BLOCK])
    elapsed = time.process_time() - start
    if rig.tick != TICKS + 250:
        raise SystemExit(f"the rig stopped at tick {rig.tick} of {TICKS + 250}: {rig.conditions}")
    return elapsed


def main() -> None:
    """Print one line a case."""
    print(f"{os.cpu_count()} cores, {TICKS} ticks in blocks of {BLOCK}")
    for name, effects in CASES.items():
        elapsed = measure(effects)
        per_step = elapsed / (TICKS * SUBSTEPS) * 1e9
        print(f"{name:24s} {elapsed:5.2f} s CPU   {per_step:5.1f} ns per 20 us sub-step")


if __name__ == "__main__":
    main()
