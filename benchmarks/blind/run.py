"""Make and solve scoring cases: `python -m benchmarks.blind.run OUT [SECONDS]`; then `benchmarks.blind.score OUT`.

Every effect once at full strength, those from outside the catalogue included, and ten cases with nothing hidden, in an
order drawn beforehand. Each case is made and solved by processes of their own, two at a time. Nothing new is begun
after SECONDS; a second call goes on with what is left.
"""

import os
import random
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import chain
from pathlib import Path

from benchmarks.blind.seeds import NULL_SCORING, SCORING
from discrepancy.effects.spec import Port
from discrepancy.effects.table import EFFECTS as CATALOGUE
from mock_dsp.scenario.effects import EFFECTS as PHYSICS

PROCESSES = 2
NULL_CASES = 10
LONGEST_S = 600.0
FROM_REFERENCE = {name for name, effect in CATALOGUE.items() if effect.port is Port.CURRENT}
"""Effects between reference and current: only a simulation that starts at the reference can see them."""


def cases() -> list[tuple[str, int]]:
    """Return (hidden id or `none`, seed), three effects for each case with nothing hidden."""
    hidden = list(zip(sorted(PHYSICS), SCORING, strict=False))
    random.Random(SCORING.start).shuffle(hidden)
    empty = [("none", seed) for seed in NULL_SCORING[:NULL_CASES]]
    mixed = [[*hidden[3 * k : 3 * k + 3], empty[k]] for k in range(NULL_CASES)]
    return [*chain.from_iterable(mixed), *hidden[3 * NULL_CASES :]]


def play(root: Path, deadline: float, case: tuple[str, int]) -> None:
    """Make and solve one case, unless it is too late or done."""
    name, seed = case
    folder = root / f"{name}-{seed}"
    if time.monotonic() > deadline or (folder / "verdict.json").exists():
        return
    column = "current_ref_A" if name in FROM_REFERENCE else "current_A"
    # One thread of linear algebra a process: more would fight over the cores that the cases share.
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    for step in (["generate", str(folder), name, str(seed)], ["solve", str(folder), column]):
        command = [sys.executable, "-m", f"benchmarks.blind.{step[0]}", *step[1:]]
        done = subprocess.run(command, env=environment, check=False, timeout=LONGEST_S)
        if done.returncode != 0:
            print(f"{name} {seed}: {step[0]} failed", file=sys.stderr)
            return


def main(root: Path, seconds: float) -> None:
    """Play all cases."""
    with ThreadPoolExecutor(PROCESSES) as executor:
        list(executor.map(partial(play, root, time.monotonic() + seconds), cases()))


if __name__ == "__main__":
    main(Path(sys.argv[1]), float(sys.argv[2]) if len(sys.argv) > 2 else 1e9)
