"""Open the answers of solved blind cases and count: `python -m benchmarks.blind.score OUT [OUT ...]` prints Markdown.

Answers of a condition are opened only when every case of its plan has a verdict; `--partial` lifts that for development
seeds, never for scoring seeds.
"""

import argparse
import json
from collections.abc import Iterator
from pathlib import Path

from benchmarks.blind.conditions import Case
from benchmarks.blind.figures import Solved, read_solved
from benchmarks.blind.run import answer_path, verdict_path
from benchmarks.blind.tables import case_line, condition_table, figure_table, id_table, outside_table


def read_condition(folder: Path, partial: bool) -> Iterator[Solved]:
    """Yield the solved cases of one condition.

    Raises:
        SystemExit: cases of the plan have no verdict yet.
    """
    plan = json.loads((folder / "plan.json").read_text(encoding="utf-8"))
    cases = [Case(**case) for case in plan["cases"]]
    root = folder.parent
    done = [case for case in cases if verdict_path(root, case).with_suffix(".json").exists()]
    if len(done) < len(cases) and not (partial and plan["set"] == "development"):
        raise SystemExit(
            f"{folder}: {len(cases) - len(done)} of {len(cases)} cases have no verdict yet; the answers stay closed. "
            f"Call benchmarks.blind.run again (development seeds may be scored with --partial)"
        )
    for case in done:
        yield read_solved(answer_path(root, case), verdict_path(root, case))


def main() -> None:
    """Print the tables of all conditions found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path, nargs="+")
    parser.add_argument("--partial", action="store_true", help="score development cases of an unfinished run")
    parser.add_argument("--cases", action="store_true", help="print one line a case too")
    options = parser.parse_args()
    solved: dict[str, list[Solved]] = {}
    for root in options.out:
        for plan in sorted(root.glob("*/plan.json")):
            solved.setdefault(plan.parent.name, []).extend(read_condition(plan.parent, options.partial))
    if options.cases:
        for cases in solved.values():
            print("\n".join(case_line(one) for one in cases))
    for table in (condition_table, figure_table, outside_table, id_table):
        print("\n".join(table(solved)) + "\n")


if __name__ == "__main__":
    main()
