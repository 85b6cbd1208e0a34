"""`jointscope identify` on two 1001 s recordings: how long until the first estimate is printed, cold and warm.

    python -m benchmarks.command_line

Cold means an empty cache of compiled kernels; the operating system's file cache is warm in both cases.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
WARM_RUNS = 5


def record_pair(folder: Path) -> tuple[Path, Path]:
    """Record the paper's two experiments on the emulated rig."""
    campaign = ROOT / "config" / "campaigns" / "paper.yaml"
    command = [sys.executable, "-m", "server", "run", str(campaign), "--out", str(folder)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, cwd=ROOT)
    return folder / "records" / "train.parquet", folder / "records" / "test.parquet"


def time_first_estimate(train: Path, test: Path, out: Path, cache: Path) -> tuple[float, float]:
    """Return the seconds to the first printed estimate and to the end."""
    command = [
        sys.executable,
        "-m",
        "server",
        "identify",
        "--train",
        str(train),
        "--test",
        str(test),
        "--out",
        str(out),
    ]
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache), "PYTHONUNBUFFERED": "1"}
    begin = time.perf_counter()
    first = float("nan")
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment, cwd=ROOT) as process:
        assert process.stdout is not None  # noqa: S101  # opened as a pipe above
        for line in process.stdout:
            if "first estimate" in line:
                first = time.perf_counter() - begin
                break
        process.communicate()
    return first, time.perf_counter() - begin


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        train, test = record_pair(folder / "run")
        cold = time_first_estimate(train, test, folder / "cold", folder / "cache")
        warm = [
            time_first_estimate(train, test, folder / f"warm{i}", folder / "cache") for i in range(WARM_RUNS)
        ]
        warm.sort()
        print("| | first estimate [s] | with report [s] |")
        print("|---|---|---|")
        print(f"| cold | {cold[0]:.2f} | {cold[1]:.2f} |")
        print(
            f"| warm, median of {WARM_RUNS} | {warm[WARM_RUNS // 2][0]:.2f} | {warm[WARM_RUNS // 2][1]:.2f} |"
        )


if __name__ == "__main__":
    main()
