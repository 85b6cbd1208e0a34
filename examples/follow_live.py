"""Follow a rig's current and speed live, as numpy arrays.

python -m examples.follow_live emulated 20
"""

import sys

from jointscope_client.client import Client


def main(rig: str, frames: str) -> None:
    """Print the newest values of some frames; a frame is what came together, some 50 ms of samples."""
    with Client() as client:
        seen = 0
        for frame in client.live(rig, ["current_A", "speed_rad_s"]):
            if frame.rows:
                current, speed = frame["current_A"], frame["speed_rad_s"]  # float32, shape (rows,)
                print(f"tick {frame.tick}: {frame.rows} rows, {current[-1]:.3f} A, {speed[-1]:.3f} rad/s")
                seen += 1
            if seen == int(frames):
                break


if __name__ == "__main__":
    main(*sys.argv[1:])
