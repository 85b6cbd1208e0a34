"""Make and solve blind cases: `python -m benchmarks.blind.run OUT --set development|scoring --condition C[,C...]`.

Every case is made by one process and solved by another, which is told where the question lies and where to put the
verdict, and nothing else. OUT/CONDITION holds `plan.json` (the cases), `answers/` and `verdicts/`; questions are
deleted once solved, a seed makes them again. A second call with the same plan goes on with what is left; a longer plan
adds to it. `benchmarks.blind.score` opens the answers.
"""

import argparse
import json
import queue
import shutil
import threading
import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from benchmarks.blind.conditions import CONDITIONS, Case, list_cases
from benchmarks.blind.worker import Worker, WorkerError

GENERATOR = "benchmarks.blind.generate"
SOLVER = "benchmarks.blind.solve"


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """How cases are played.

    Attributes:
        solver: module of the solver.
        deadline_s: monotonic time after which nothing new is begun.
        longest_s: time allowed to solve one case.
        keep: whether questions are kept.
    """

    solver: str
    deadline_s: float
    longest_s: float
    keep: bool


def verdict_path(root: Path, case: Case) -> Path:
    """Return where a case's verdict stands, without suffix."""
    return root / case.condition / "verdicts" / case.key


def answer_path(root: Path, case: Case) -> Path:
    """Return where a case's answer stands, without suffix."""
    return root / case.condition / "answers" / case.key


def write_plan(root: Path, cases: Sequence[Case], name: str) -> None:
    """Add cases to the plan of each condition; the scorer waits for all of them.

    Raises:
        ValueError: the folder holds the other set.
    """
    for condition in dict.fromkeys(case.condition for case in cases):
        path = root / condition / "plan.json"
        path.parent.mkdir(parents=True, exist_ok=True)
        old: dict[str, Any] = {"set": name, "cases": []}  # what json.loads returns
        if path.exists():
            old = json.loads(path.read_text(encoding="utf-8"))
        if old["set"] != name:
            raise ValueError(f"{path.parent} holds {old['set']} cases; use another folder for {name}")
        new = [asdict(case) for case in cases if case.condition == condition]
        plan = {"set": name, "cases": old["cases"] + [case for case in new if case not in old["cases"]]}
        path.write_text(json.dumps(plan, indent=1), encoding="utf-8")


def play(root: Path, case: Case, workers: tuple[Worker, Worker], plan: Plan) -> None:
    """Make and solve one case; a failure of the solver is its verdict."""
    generator, solver = workers
    question, verdict = root / case.condition / "questions" / case.key, verdict_path(root, case)
    request = {"condition": case.condition, "id": case.id, "seed": str(case.seed)}
    generator.ask(
        request | {"question": str(question), "answer": str(answer_path(root, case))}, plan.longest_s
    )
    start = time.perf_counter()
    try:
        solver.ask({"question": str(question), "verdict": str(verdict)}, plan.longest_s)
    except WorkerError as error:
        failed: dict[str, object] = {"verdict": "failed", "message": str(error), "steps": [], "effects": []}
        failed["wall_seconds"] = time.perf_counter() - start
        verdict.parent.mkdir(parents=True, exist_ok=True)
        verdict.with_suffix(".json").write_text(json.dumps(failed), encoding="utf-8")
    if not plan.keep:
        shutil.rmtree(question)


def work(root: Path, waiting: "queue.SimpleQueue[Case]", plan: Plan) -> None:
    """Play waiting cases with two processes until none is left or it is too late."""
    with ExitStack() as stack:
        (root / "log").mkdir(parents=True, exist_ok=True)
        log = stack.enter_context((root / "log" / f"{threading.current_thread().name}.txt").open("a"))
        generator, solver = Worker(GENERATOR, log), Worker(plan.solver, log)
        stack.callback(generator.stop)
        stack.callback(solver.stop)
        while time.monotonic() < plan.deadline_s:
            try:
                case = waiting.get_nowait()
            except queue.Empty:
                return
            try:
                play(root, case, (generator, solver), plan)
            except WorkerError as error:
                print(f"{case.condition} {case.id} {case.seed}: not made: {error}", flush=True)


def run(root: Path, cases: Sequence[Case], jobs: int, plan: Plan) -> int:
    """Play the cases that have no verdict yet; return how many are still open."""
    waiting: queue.SimpleQueue[Case] = queue.SimpleQueue()
    for case in cases:
        if not verdict_path(root, case).with_suffix(".json").exists():
            waiting.put(case)
    threads = [threading.Thread(target=work, args=(root, waiting, plan), name=f"job{k}") for k in range(jobs)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return sum(not verdict_path(root, case).with_suffix(".json").exists() for case in cases)


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--set", choices=("development", "scoring"), required=True, dest="chosen")
    parser.add_argument(
        "--condition", required=True, help="comma-separated, or all: " + ", ".join(CONDITIONS)
    )
    parser.add_argument("--ids", help="comma-separated; default: all of the condition")
    parser.add_argument("--count", type=int, help="cases an id; default: the condition's own")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument(
        "--limit", type=float, default=float("inf"), help="begin nothing new after so many seconds"
    )
    parser.add_argument("--longest", type=float, default=600.0, help="seconds allowed for one case")
    parser.add_argument("--solver", default=SOLVER, help="module; benchmarks.blind.sindy is the rival")
    parser.add_argument("--keep", action="store_true", help="keep the questions")
    return parser.parse_args()


def main() -> None:
    """Run from the command line."""
    options = parse()
    names = list(CONDITIONS) if options.condition == "all" else options.condition.split(",")
    ids = None if options.ids is None else tuple(options.ids.split(","))
    scoring = options.chosen == "scoring"
    cases = [
        case for name in names for case in list_cases(name, scoring=scoring, ids=ids, count=options.count)
    ]
    write_plan(options.out, cases, options.chosen)
    plan = Plan(
        solver=options.solver, deadline_s=time.monotonic() + options.limit, longest_s=options.longest,
        keep=options.keep,
    )  # fmt: skip
    left = run(options.out, cases, options.jobs, plan)
    print(f"{len(cases) - left} of {len(cases)} cases have a verdict")


if __name__ == "__main__":
    main()
