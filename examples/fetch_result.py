"""Upload a measured file, find it again, and compute with its samples as numpy arrays.

python -m examples.fetch_result measured.csv
"""

import sys
from pathlib import Path

import numpy as np

from jointscope_client.client import Client


def main(measured_file: str) -> None:
    """Print how current and speed hang together."""
    with Client() as client:
        recording = client.recordings.upload(Path(measured_file))
        samples = client.recordings.samples(recording.id, ["current_A", "speed_rad_s"])
        current, speed = samples["current_A"], samples["speed_rad_s"]  # float64, all digits
        print(f"{recording.name}: {samples.rows} samples of {samples.sample_time_s:g} s, id {recording.id}")
        print(f"largest current {np.abs(current).max():.3f} {samples.units['current_A']}")
        print(f"correlation of current and speed: {np.corrcoef(current, speed)[0, 1]:.3f}")

        drawn = client.recordings.samples(
            recording.id, ["speed_rad_s"], points=500
        )  # for a plot: no peak is lost
        print(f"{drawn.rows} points to draw {drawn.of_rows} samples")


if __name__ == "__main__":
    main(*sys.argv[1:])
