"""Identify a joint: create a session, start it, follow its estimates live, and fetch the result as numpy.

python -m examples.identify_joint emulated 20
"""

import sys

import numpy as np

from jointscope_client.client import Client

EXCITATION = {"kind": "multisine", "amplitude_A": 0.8, "period_s": 5, "lines": 8, "seed": 7, "ramp_s": 0.5}


def main(rig: str, duration_s: str) -> None:
    """Print the estimates of recursive least squares while they come, then the identified model."""
    with Client() as client:
        session = client.create_session(
            name="example",
            rig=rig,
            excitation=EXCITATION,
            duration_s=float(duration_s),
            sample_time_s=0.05,
            estimators=[{"name": "rls"}, {"name": "ls"}],
        )
        client.sessions.command(session.id, "start")
        for moment in client.follow_session(session.id, interval_ms=500):
            now = (moment.provisional or moment.estimates).get("rls")
            if now is not None:
                told = ", ".join(
                    f"{name} = {value:.4f} +- {error:.4f}"
                    for name, value, error in zip(now.names, now.values, now.errors, strict=True)
                )
                print(
                    f"{moment.state}, {moment.samples_received} samples, {moment.samples_lost} lost: {told}"
                )
        client.sessions.wait(session.id)  # raises what went wrong, if anything did

        methods = client.identification(session.id)["methods"]
        theta = np.array([each["value"] for each in methods["ls"]["parameters"]])
        poles = np.roots([1.0, *theta[:2]])  # y(k) + a1 y(k-1) + a2 y(k-2) = b0 u(k-1) + b1 u(k-2)
        print(f"poles at {np.round(poles, 4)}, DC gain {theta[2:].sum() / (1 + theta[:2].sum()):.3f}")
        recording = client.sessions.get(session.id).raw["recording_id"]
        samples = client.recordings.samples(recording, ["current_A", "speed_rad_s"], points=1000)
        print(f"greatest speed {samples['speed_rad_s_max'].max():.2f} rad/s")


if __name__ == "__main__":
    main(*sys.argv[1:])
