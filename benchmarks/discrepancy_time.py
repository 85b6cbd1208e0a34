"""Time a case of the discrepancy workflow: 40 s at 2.5 kHz, played twice, report included.

`python -m benchmarks.discrepancy_time [--ids ID,ID] [--nothing N] [--jobs N]` makes one development case of every
effect, and N in which nothing is hidden, and solves each one in this process. Reading the model, search and report
count; making the case does not. Screening is the first round's: all starts of all effects, beside the recalibrated
joint, timed alone. Processor time is printed beside wall time, since only the first is the workflow's
own on a machine that does other work. With `--jobs` each case is solved once more over so many processes; that column
is wall time alone. The first case is solved once before, so that no figure holds the compiling of kernels.
"""

import argparse
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from benchmarks.blind.conditions import IDS, Case, list_cases
from benchmarks.blind.generate import generate
from benchmarks.blind.question import Question, read_question
from benchmarks.blind.solve import recordings
from discrepancy.data.series import read_series
from discrepancy.model.reader import parse_model
from discrepancy.prepare import prepare_simulation
from discrepancy.report.files import write_result
from discrepancy.search.greedy import screen
from discrepancy.search.noise import waves_left
from discrepancy.workflow import GapOptions, run_gap


@dataclass(frozen=True, slots=True, kw_only=True)
class Spent:
    """Seconds that one case took: processor and wall time of the whole, those of the report and of screening alone."""

    cpu: float
    wall: float
    report: float
    screening: float
    answer: str


def solve(question: Question, executor: Executor | None, out: Path) -> Spent:
    """Solve a case and write its report."""
    cpu, wall = time.process_time(), time.perf_counter()
    records = recordings(question)
    options = GapOptions(executor=executor)
    result = run_gap(parse_model(question.model), records.train, records.test, options)
    searched = time.process_time()
    write_result(result, out)
    cpu, wall, report = time.process_time() - cpu, time.perf_counter() - wall, time.process_time() - searched
    return Spent(
        cpu=cpu, wall=wall, report=report, screening=screening_time(question),
        answer=" ".join((result.verdict, *result.effects)),
    )  # fmt: skip


def screening_time(question: Question) -> float:
    """Return the wall time of the first round's screening, s."""
    model = parse_model(question.model)
    train = [read_series(one, model, "train") for one in recordings(question).train]
    prepared = prepare_simulation(model, train, None)
    ranges = replace(prepared.ranges, waves=waves_left(prepared.problem, prepared.state))
    begun = time.perf_counter()
    screen(prepared.problem, prepared.state, ranges, prepared.context)
    return time.perf_counter() - begun


def chosen_cases(ids: Sequence[str], nothing: int) -> list[Case]:
    """Return the development cases to be solved."""
    full = list_cases("full", scoring=False, ids=tuple(ids), count=1)
    return full + list_cases("null_emulator", scoring=False, count=nothing)


def row(case: Case, own: Spent, shared: Spent | None) -> str:
    """Return the line of one case."""
    wall = "" if shared is None else f"{shared.wall:7.2f}"
    numbers = " ".join(f"{value:7.2f}" for value in (own.cpu, own.wall, own.report, own.screening))
    return f"{case.id:30s} {numbers} {wall:>8s}  {own.answer}"


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--ids", default=",".join(IDS), help="comma-separated; default: all")
    parser.add_argument("--nothing", type=int, default=4, help="cases in which nothing is hidden")
    parser.add_argument("--jobs", type=int, default=1)
    asked = parser.parse_args()
    cases = chosen_cases([name for name in asked.ids.split(",") if name], asked.nothing)
    spent: list[tuple[Spent, Spent | None]] = []
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        pool = None
        if asked.jobs > 1:
            pool = stack.enter_context(ProcessPoolExecutor(asked.jobs, mp_context=get_context("spawn")))
        print(
            f"{'hidden':30s} {'CPU s':>7s} {'wall s':>7s} {'report':>7s} {'screen':>7s} {'wall, N':>8s}  answer",
            flush=True,
        )
        for number, case in enumerate(cases):
            generate(case, folder / case.key / "question", folder / case.key / "answer")
            question = read_question(folder / case.key / "question")
            if number == 0:
                for executor in (None, *([pool] if pool else [])):
                    solve(question, executor, folder / "warm")
            own = solve(question, None, folder / case.key)
            shared = solve(question, pool, folder / case.key) if pool else None
            spent.append((own, shared))
            print(row(case, own, shared), flush=True)
    columns = {
        "CPU": [own.cpu for own, _ in spent],
        "wall": [own.wall for own, _ in spent],
        "report, CPU": [own.report for own, _ in spent],
        "screening, wall": [own.screening for own, _ in spent],
        f"wall, {asked.jobs} processes": [shared.wall for _, shared in spent if shared],
    }
    for name, values in columns.items():
        if values:
            print(f"{name}: median {np.median(values):.2f} s, worst {max(values):.2f} s")


if __name__ == "__main__":
    main()
