"""Choose the rival's settings on development seeds: `python -m benchmarks.blind.sindy_sweep [NULLS HIDDEN]`.

For each way to run it, the gate that lets something be named in at most 1 % of the development cases with nothing
hidden; then how many of the visible development cases of condition `full` it answers rightly. The best goes into
`sindy.SETTINGS` by hand.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

from benchmarks.blind.conditions import list_cases
from benchmarks.blind.emulated import make_emulated
from benchmarks.blind.figures import VISIBLE
from benchmarks.blind.judge import Worth, classify
from benchmarks.blind.question import Question
from benchmarks.blind.sindy import Measure, Method, Settings, Sparse, sparse_laws, verdict_of
from benchmarks.blind.sindy_library import Balance, balance

NULLS = ("null_emulator", "null_white", "null_coloured", "null_quantised")
WINDOWS_S = (0.02, 0.1, 0.5, 2.0)
RIDGES = (1e-4, 0.05)
THRESHOLDS = (0.03, 0.1, 0.2, 0.4, 0.8)
ALARMS = 0.01
SEEN_NULLS, SEEN_HIDDEN = 60, 4
"""Cases of each id that choose the settings; `sindy_check.py` scores on later ones."""
NOTHING_HELD: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True, kw_only=True)
class Prepared:
    """A case with its momentum balances by window."""

    hidden: list[str]
    question: Question
    balances: dict[float, Balance]

    def solve(self, settings: Settings) -> Sparse:
        """Return the laws kept."""
        return sparse_laws(self.balances[settings.window_s], NOTHING_HELD, settings)

    def worth(self, found: Sparse, settings: Settings) -> Worth:
        """Return what the answer is worth."""
        data = self.balances[settings.window_s]
        return classify(self.hidden, verdict_of(found, settings, self.question, data))


def prepare(
    condition: str, count: int, skip: int = 0, windows: Sequence[float] = WINDOWS_S
) -> list[Prepared]:
    """Return visible development cases without their records, which the balances replace.

    Args:
        condition: of the blind benchmark.
        count: cases of each id.
        skip: of these, cases of each id that are left out.
        windows: lengths of the balances, s.
    """
    found = []
    first = skip * len(list_cases(condition, scoring=False, count=1))
    for case in list_cases(condition, scoring=False, count=count)[first:]:
        made = make_emulated(case)
        if min(made.answer.gap.values(), default=VISIBLE) < VISIBLE:
            continue
        balances = {window: balance(made.question, window) for window in windows}
        question = replace(made.question, records={})
        found.append(Prepared(hidden=made.answer.hidden, question=question, balances=balances))
    return found


def ways() -> list[Settings]:
    """Return all ways to run it, without a gate."""
    thresholded = [
        Settings(
            method=Method.STLSQ,
            window_s=window,
            ridge=ridge,
            threshold=threshold,
            most=most,
            measure=Measure.SHARE,
            gate=0.0,
        )
        for window, ridge, threshold, most in product(WINDOWS_S, RIDGES, THRESHOLDS, (0, 1))
    ]
    forward = [
        Settings(
            method=Method.FROLS,
            window_s=window,
            ridge=1e-4,
            threshold=0.0,
            most=most,
            measure=Measure.SHARE,
            gate=0.0,
        )
        for window, most in product(WINDOWS_S, (1, 2, 3))
    ]
    return thresholded + forward


def calibrated(settings: Settings, found: Sequence[Sparse]) -> Settings:
    """Return these settings with the gate that at most ALARMS of the cases with nothing hidden pass with a name."""
    reached = sorted((one.measured(settings.measure) for one in found if any(one.names)), reverse=True)
    allowed = int(ALARMS * len(found))
    return replace(settings, gate=reached[allowed] if len(reached) > allowed else 0.0)


def main(nulls: int, hidden: int) -> None:
    """Print every combination with what it reaches, the best last."""
    empty = [case for condition in NULLS for case in prepare(condition, nulls)]
    full = prepare("full", hidden)
    rows = []
    for way in ways():
        nothing, something = ([case.solve(way) for case in cases] for cases in (empty, full))
        for measure in Measure:
            settings = calibrated(replace(way, measure=measure), nothing)
            worths = [case.worth(found, settings) for case, found in zip(full, something, strict=True)]
            rows.append((worths.count(Worth.RIGHT), worths.count(Worth.WRONG), settings))
    for right, wrong, settings in sorted(rows, key=lambda row: row[0]):
        print(
            f"right {right}/{len(full)} wrong {wrong} at 1 % of {len(empty)} with nothing hidden: {settings}"
        )


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:3])) if len(sys.argv) > 2 else main(
        SEEN_NULLS, SEEN_HIDDEN
    )
