"""One rig at real time with a busy machine: no sample lost, and what the host spends on it.

    python -m benchmarks.soak [MINUTES]        (30 by default)

The emulated controller runs at 1x with its modelled line and 16-octet FIFO. One process burns a core all the time. The
drive is on and plays a sine; everything goes into a journal. CPU is this process alone: driver, decoding and journal.
The lease is the one of config/rigs/emulated.yaml, 1 s: this is about samples, not about how soon a stalled host trips.
"""

import multiprocessing
import resource
import sys
import tempfile
from pathlib import Path

from benchmarks.emulated import emulated_controller
from daq.driver.options import RecordPlan, RigOptions
from daq.driver.outcome import RecordOutcome
from daq.driver.rig import open_rig
from daq.driver.session import record
from daq.excitation.check import Nameplate
from daq.excitation.spec import Sine
from daq.recording.header import make_header
from daq.recording.journal import Journal

JOINT = Nameplate(inertia_kg_m2=0.5, viscous_friction_nm_s_rad=0.9, torque_constant_nm_a=1.0)


def burn() -> None:
    """Keep one core busy until killed."""
    while True:
        sum(range(10_000))


def soak(port: str, minutes: float, folder: Path) -> tuple[RecordOutcome, float]:
    """Record for `minutes`; return the outcome and the CPU seconds of this process."""
    with open_rig(port, RigOptions()) as rig:
        header = make_header(dictionary=rig.dictionary_octets, tick_hz=rig.hello.tick_hz, divisor=1)
        journal = Journal.create(folder / "soak.journal", header)
        before = resource.getrusage(resource.RUSAGE_SELF)
        plan = RecordPlan(
            excitation=Sine(amplitude_a=0.5, period_s=10.0, ramp_s=2.0),
            duration_s=60.0 * minutes,
            nameplate=JOINT,
            lease_ms=1000,
        )
        outcome = record(rig, plan, journal)
        after = resource.getrusage(resource.RUSAGE_SELF)
        journal.close(outcome.end.value)
    return outcome, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Run the soak and print what was lost and spent."""
    minutes = float(sys.argv[1]) if len(sys.argv) > 1 else 30.0
    burner = multiprocessing.get_context("spawn").Process(target=burn, daemon=True)
    burner.start()
    try:
        with tempfile.TemporaryDirectory() as folder, emulated_controller("1") as port:
            outcome, cpu_s = soak(port, minutes, Path(folder))
    finally:
        burner.terminate()
    print(f"ended: {outcome.end.value} ({outcome.text})")
    print(
        f"samples expected {outcome.samples_expected}, received {outcome.samples_received}, lost {outcome.samples_lost}"
    )
    print(f"host CPU {cpu_s:.1f} s in {minutes:g} min: {cpu_s / (60.0 * minutes):.2%} of a core")


if __name__ == "__main__":
    main()
