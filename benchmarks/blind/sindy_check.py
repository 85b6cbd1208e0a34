"""Score the rival with its chosen settings on development cases that did not choose them.

`python -m benchmarks.blind.sindy_check [HIDDEN NULLS]`: HIDDEN more cases of condition `full` for each id, and NULLS
more of each condition with nothing hidden, after those that `sindy_sweep.py` has seen. Prints right and wrong names,
how many were named though nothing was hidden, and the interval of each (Wilson).
"""

import sys

from benchmarks.blind.judge import Worth, wilson
from benchmarks.blind.sindy import SETTINGS
from benchmarks.blind.sindy_sweep import NULLS, SEEN_HIDDEN, SEEN_NULLS, prepare


def main(hidden: int, nulls: int) -> None:
    """Print both figures."""
    full = prepare("full", SEEN_HIDDEN + hidden, SEEN_HIDDEN, (SETTINGS.window_s,))
    worths = [case.worth(case.solve(SETTINGS), SETTINGS) for case in full]
    for worth in (Worth.RIGHT, Worth.WRONG):
        print(worth.value, _share(worths.count(worth), len(worths)), flush=True)
    empty = [
        case
        for condition in NULLS
        for case in prepare(condition, SEEN_NULLS + nulls, SEEN_NULLS, (SETTINGS.window_s,))
    ]
    named = sum(
        any(found.names) and found.measured(SETTINGS.measure) > SETTINGS.gate
        for found in (case.solve(SETTINGS) for case in empty)
    )
    print("named with nothing hidden", _share(named, len(empty)))


def _share(count: int, number: int) -> str:
    low, high = wilson(count, number)
    return f"{count} of {number} ({100 * low:.1f} to {100 * high:.1f} %)"


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:3])) if len(sys.argv) > 2 else main(1, 15)
