"""The paper's campaign end to end: how long each 1001 s experiment takes, through the pseudo-terminal.

    python -m benchmarks.paper_campaign [RUNS]

Times are those of the run folder's manifest: recording, decoding and finalising of 2.5 million samples included.
"""

import json
import subprocess
import sys
import tempfile
import time
from datetime import datetime
from pathlib import Path

ROOT = Path(__file__).parents[1]
CAMPAIGN = ROOT / "config" / "campaigns" / "paper.yaml"


def seconds_of(step: dict[str, str]) -> float:
    """Return how long a step of the manifest took."""
    return (
        datetime.fromisoformat(step["ended_at"]) - datetime.fromisoformat(step["started"])
    ).total_seconds()


def main() -> None:
    """Run the campaign and print the times of its steps."""
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 2
    print("| run | " + "train [s] | test [s] | identify [s] | whole command [s] |")
    print("|---|---|---|---|---|")
    for run in range(1, runs + 1):
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "run"
            begin = time.perf_counter()
            command = [sys.executable, "-m", "server", "run", str(CAMPAIGN), "--out", str(out)]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL, cwd=ROOT)
            whole = time.perf_counter() - begin
            steps = json.loads((out / "manifest.json").read_text())["steps"]
            cells = " | ".join(f"{seconds_of(step):.1f}" for step in steps)
            print(f"| {run} | {cells} | {whole:.1f} |", flush=True)


if __name__ == "__main__":
    main()
