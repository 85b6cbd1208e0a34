"""Run the benchmark programs one after the other: `python -m benchmarks [NAME ...]`.

Each program stands alone and prints its own table; this file only lists them, says on which machine they run, and
reports those that failed. `soak` and `service_kill` last long and run only when they are
named.
"""

import os
import platform
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
PROGRAMS = {
    "protocol_decode": "decoding of the stream, efficiency of the wire",
    "wire_counters": "line use: computed, and counted by the emulated controller",
    "driver_ceiling": "samples a second through a pseudo-terminal into a journal",
    "emulator_physics": "cost of the emulated rig's physics",
    "recording": "size and speed of recordings",
    "speed": "error of the speed from the potentiometer",
    "estimators": "time and agreement of the estimators beside other packages",
    "estimators_statistics": "coverage of the intervals, bias of instrumental variables",
    "estimators_ranking": "does the paper's ranking appear, and by which figure",
    "paper_campaign": "the two 1001 s experiments, end to end",
    "command_line": "first estimate from the command line, cold and warm",
    "scaling": "what a night of 10,000 joints needs",
    "service_latency": "age of the newest sample at a WebSocket client",
    "service_load": "eight rigs, fifty viewers, five of them slow",
    "service_startup": "start with 10,000 recordings in the store",
    "service_schemathesis": "thousands of generated requests",
    "discrepancy_time": "processor and wall time of a case of the discrepancy workflow",
    "real_data": "the torque limits on splits of measured training records",
    "soak": "half an hour at 1x with the other core busy",
    "service_kill": "kill -9 of the service at 50 random moments of a campaign",
}
ONLY_WHEN_NAMED = ("soak", "service_kill")


def main(names: list[str]) -> int:
    """Run the named programs, or all but the long ones; return 1 if any failed."""
    unknown = [name for name in names if name not in PROGRAMS]
    if unknown:
        print(f"unknown: {', '.join(unknown)}; there are {', '.join(PROGRAMS)}", file=sys.stderr)
        return 2
    print(f"{platform.platform()}, Python {platform.python_version()}, {os.cpu_count()} cores", flush=True)
    failed = []
    for name in names or [name for name in PROGRAMS if name not in ONLY_WHEN_NAMED]:
        print(f"\n== {name}: {PROGRAMS[name]}", flush=True)
        if subprocess.run([sys.executable, "-m", f"benchmarks.{name}"], check=False, cwd=ROOT).returncode:
            failed.append(name)
    if failed:
        print(f"\nfailed: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
