"""Positions and true speeds of the emulated joint, for `benchmarks/speed.py`.

A process of its own, because nothing but the emulator's starter may know the emulator. It writes one `.npz`
per motion into the folder given and prints their paths as JSON.
"""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from mock_dsp.control.parameters import FastLoopParameters
from mock_dsp.physics.rig import EmulatedRig
from mock_dsp.scenario.schema import Effect, Scenario

TICK_S = 4e-4
DURATION_S = 100.0
HIDDEN = ("stribeck_friction", "torque_ripple")


def main() -> None:
    """Run the motions and say where they are."""
    folder = Path(sys.argv[1])
    time_s = np.arange(0.0, DURATION_S, TICK_S)
    rng = np.random.default_rng(1)
    prbs = np.repeat(rng.choice([-1.0, 1.0], size=round(DURATION_S / 0.1)), round(0.1 / TICK_S))
    sine = np.sin(2.0 * np.pi * time_s / 10.0)
    references = {
        "sine 10 s": (sine, ()),
        "trapezoid 50 s": (np.clip(3.0 * np.sin(2.0 * np.pi * time_s / 50.0), -1.0, 1.0), ()),
        "PRBS 0.1 s": (prbs[: len(time_s)], ()),
        "sine with stick and ripple": (sine, HIDDEN),
    }
    paths = {}
    for number, (name, (reference_a, hidden)) in enumerate(references.items()):
        scenario = Scenario(name=name, effects=tuple(Effect(id=effect) for effect in hidden))
        rig = EmulatedRig.from_scenario(scenario)
        rig.set_parameters(replace(FastLoopParameters(), pwm_on=True))
        trace = rig.run(reference_a)
        if trace.trip is not None:
            raise SystemExit(f"{name}: the rig tripped ({trace.trip.name}) after {trace.ticks_done} ticks")
        paths[name] = str(folder / f"motion{number}.npz")
        np.savez(paths[name], position_counts=trace.position_counts, speed_rad_s=trace.true_speed_rad_s)
    sys.stdout.write(json.dumps(paths))


if __name__ == "__main__":
    main()
