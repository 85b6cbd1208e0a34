"""Make blind cases in a process of its own; see `serve.py` for how it is asked.

For one by hand: `python -m benchmarks.blind.generate CONDITION ID SEED OUT` writes OUT/question and OUT/answer.json.
"""

import sys
from pathlib import Path

from benchmarks.blind.conditions import CONDITIONS, Case, Truth
from benchmarks.blind.emulated import make_emulated
from benchmarks.blind.question import write_answer, write_question
from benchmarks.blind.second import make_second
from benchmarks.blind.serve import Request, serve


def generate(case: Case, question: Path, answer: Path) -> None:
    """Write the question into one folder and the answer to a path that the solver is not given."""
    second = CONDITIONS[case.condition].truth is Truth.SECOND
    made = make_second(case) if second else make_emulated(case)
    write_answer(made.answer, made.clean_test, made.question.step_s, answer)
    write_question(made.question, question)


def handle(request: Request) -> None:
    """Make the case that a request describes."""
    case = Case(condition=request["condition"], id=request["id"], seed=int(request["seed"]))
    generate(case, Path(request["question"]), Path(request["answer"]))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        out = Path(sys.argv[4])
        generate(
            Case(condition=sys.argv[1], id=sys.argv[2], seed=int(sys.argv[3])),
            out / "question",
            out / "answer",
        )
    else:
        serve(handle)
