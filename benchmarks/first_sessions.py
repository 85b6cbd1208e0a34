"""What is said after a rig's first session: a weak sine of 10 s played twice, one hidden effect.

Such a session is short and quiet, so that what is wrong at the ends of a record weighs more than in a rich one. The
cases are those that `benchmarks.designed_experiments` begins with, on seeds of their own: those from 39,000,050 are for
developing, those from 43,000,000 (written down before anything was run on them) for scoring.

Run: python -m benchmarks.first_sessions [--set development|scoring] [--count N]   (N of each of the eight effects;
about three seconds a case)
"""

import argparse
from collections import Counter

from benchmarks.designed_experiments import EFFECTS, ROOT, Case
from discrepancy.model.reader import read_model
from discrepancy.result import GapResult
from discrepancy.workflow import GapOptions, run_gap
from server.services.loading import load_rig
from server.services.rehearsal import design_limits

FIRST_SEED = {"development": 39_000_050, "scoring": 43_000_000}
VERDICTS = ("right", "wrong", "unknown", "none")


def judged(result: GapResult, hidden: str) -> str:
    """Return whether an answer is right (the name, or one declared equivalent), wrong, `unknown` or `none`."""
    if not result.effects:
        return result.verdict
    alone = result.verdict == "named" and len(result.effects) == 1
    return "right" if alone and hidden in (*result.effects, *result.steps[-1].equivalents) else "wrong"


def main(first_seed: int, count: int) -> None:
    """Solve all cases and print the counts."""
    limits = design_limits(load_rig(ROOT / "config" / "rigs" / "emulated.yaml"))
    model = read_model(ROOT / "config" / "models" / "joint1.yaml")
    found: Counter[str] = Counter()
    for j, name in enumerate(EFFECTS):
        for k in range(count):
            case = Case(name, first_seed + 1000 * j + 100 * k, limits)
            result = run_gap(model, case.first, [case.test], GapOptions(limits=limits))
            verdict = judged(result, name)
            found[verdict] += 1
            print(name, k, verdict, *result.effects, flush=True)
    print("| " + " | ".join(VERDICTS) + " |")
    print("| " + " | ".join(str(found[verdict]) for verdict in VERDICTS) + " |")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--set", choices=tuple(FIRST_SEED), default="development", dest="seeds")
    parser.add_argument("--count", type=int, default=6)
    options = parser.parse_args()
    main(FIRST_SEED[options.seeds], options.count)
