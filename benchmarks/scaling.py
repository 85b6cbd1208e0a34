"""What a night of 10,000 joints needs: `python -m benchmarks.scaling [CASES] [--write]`.

Plays joints on the emulator's physics (three records of 40 s at 2.5 kHz each, in a process of their own), solves them
exactly as `jointscope gap --fleet` does, and computes cores, memory, network and storage from CPU time (not wall time:
the figures hold on a busy machine), peak memory and file sizes. `--write` puts the tables into docs/scaling.md.
"""

import argparse
import math
import pickle
import platform
import statistics
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import dataclass, field
from itertools import cycle, islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import yaml

from benchmarks.blind.question import read_question
from benchmarks.blind.solve import recordings
from daq.recording.store import read_recording, write_recording
from server.services.fleet_list import FleetJoint

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "scaling.md"
BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"
HIDDEN = (
    "none",
    "coulomb_friction",
    "gravity_unbalance",
    "stribeck_friction",
    "torque_ripple",
    "load_torque_offset",
)
SEED = 910_000
"""Neither a development nor a scoring seed of the blind benchmark."""
JOINTS, NIGHT_H = 10_000, 10.0
BUSY = 0.85
"""Share of the night that the cores are counted on to work: the rest is for stragglers, restarts and repeats."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cost:
    """What one joint took."""

    hidden: str
    verdict: str
    cpu_s: float
    memory_bytes: int
    input_bytes: int
    answer_bytes: int


@dataclass(slots=True)
class CountingExecutor(Executor):
    """Runs tasks here and counts what a cluster would be sent: each shared function once, each item."""

    shared: dict[bytes, int] = field(default_factory=dict)
    tasks: int = 0
    item_bytes: int = 0
    result_bytes: int = 0
    unshared_bytes: int = 0

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Run one task.  Any: the signature of Executor."""
        content, item = pickle.dumps(fn, protocol=5), pickle.dumps((args, kwargs), protocol=5)
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        self.shared[content] = len(content)
        self.tasks += 1
        self.item_bytes += len(item)
        self.unshared_bytes += len(content) + len(item)
        self.result_bytes += len(pickle.dumps(future.result(), protocol=5))
        return future

    @property
    def shipped_bytes(self) -> int:
        """Sent to the cluster in all."""
        return sum(self.shared.values()) + self.item_bytes


def make_joint(folder: Path, hidden: str, seed: int) -> FleetJoint:
    """Play one joint and write its records and its model file."""
    condition = "null_emulator" if hidden == "none" else "full"
    command = [sys.executable, "-m", "benchmarks.blind.generate", condition, hidden, str(seed), str(folder)]
    subprocess.run(command, check=True, cwd=ROOT)
    question = read_question(folder / "question")
    records = recordings(question)
    train = tuple(
        write_recording(record, folder / f"train{i}.parquet") for i, record in enumerate(records.train)
    )
    test = tuple(
        write_recording(record, folder / f"test{i}.parquet") for i, record in enumerate(records.test)
    )
    model = folder / "model.yaml"
    model.write_text(yaml.safe_dump(question.model), encoding="utf-8")
    return FleetJoint(joint=f"{hidden}-{seed}", model=model, train=train, test=test)


def solve_alone(joint: FleetJoint) -> Cost:
    """Solve a joint in a process of its own, so that its peak memory is its own."""
    code = (
        "import pickle, sys; from server.services.joint_job import JointJob, solve_joint;"
        "sys.stdout.buffer.write(pickle.dumps(solve_joint(JointJob(joint=pickle.load(sys.stdin.buffer)))))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], input=pickle.dumps(joint), capture_output=True, check=True
    )
    answer = pickle.loads(done.stdout)
    if answer.failed:
        raise RuntimeError(f"{joint.joint}: {answer.entry['error']}")
    return Cost(
        hidden=joint.joint,
        verdict=answer.entry["verdict"],
        cpu_s=answer.entry["cpu_s"],
        memory_bytes=answer.entry["peak_memory_bytes"],
        input_bytes=sum(path.stat().st_size for path in joint.files),
        answer_bytes=sum(map(len, answer.files.values())),
    )


def count_traffic(joint: FleetJoint) -> CountingExecutor:
    """Solve a joint with its candidate fits handed out one by one, and count what travels."""
    from discrepancy.model.reader import read_model
    from discrepancy.workflow import GapOptions, run_gap

    counting = CountingExecutor()
    train, test = ([read_recording(path) for path in paths] for paths in (joint.train, joint.test))
    run_gap(read_model(joint.model), train, test, GapOptions(executor=counting))
    return counting


def report(costs: list[Cost], traffic: CountingExecutor) -> str:
    """Return the measured tables and what follows from them, as Markdown."""
    mb = 1e6
    cpu = statistics.mean(cost.cpu_s for cost in costs)
    memory = max(cost.memory_bytes for cost in costs)
    sent = statistics.mean(cost.input_bytes for cost in costs)
    back = statistics.mean(cost.answer_bytes for cost in costs)
    cores = math.ceil(JOINTS * cpu / (NIGHT_H * 3600.0 * BUSY))
    rate = JOINTS * (sent + back) / (NIGHT_H * 3600.0) * 8.0 / mb
    lines = [
        f"Measured by `python -m benchmarks.scaling {len(costs)} --write` on {platform.machine()}, Python "
        f"{platform.python_version()}; CPU time, three records of 40 s at 2.5 kHz a joint, report included.",
        "",
        "| joint | verdict | CPU [s] | peak memory [MB] | recordings [MB] | answer [MB] |",
        "|---|---|---|---|---|---|",
        *(
            f"| {c.hidden} | {c.verdict} | {c.cpu_s:.1f} | {c.memory_bytes / mb:.0f} | {c.input_bytes / mb:.2f} | "
            f"{c.answer_bytes / mb:.2f} |"
            for c in costs
        ),
        "",
        f"| {JOINTS:,} joints in {NIGHT_H:g} h | |",
        "|---|---|",
        f"| CPU time | {cpu:.1f} s a joint, {JOINTS * cpu / 3600.0:,.0f} core hours |",
        f"| cores, {BUSY:.0%} busy | **{cores}** |",
        f"| memory | {memory / mb:,.0f} MB a process, {cores * memory / 1e9:,.0f} GB in all |",
        f"| network | {JOINTS * sent / 1e9:,.0f} GB out, {JOINTS * back / 1e9:,.0f} GB back, {rate:.1f} Mbit/s |",
        f"| storage | {JOINTS * sent / 1e9:,.0f} GB of recordings, {JOINTS * back / 1e9:,.0f} GB of answers |",
        "",
        f"One joint with its fits spread over a cluster (`--model ... --cluster`): {traffic.tasks} tasks, "
        f"{traffic.shipped_bytes / mb:.1f} MB sent ({traffic.shipped_bytes / traffic.tasks / 1e3:.0f} kB a task; "
        f"{traffic.unshared_bytes / traffic.tasks / 1e3:.0f} kB if every task carried its data), "
        f"{traffic.result_bytes / mb:.1f} MB back.",
    ]
    return "\n".join(lines)


def write_page(text: str) -> None:
    """Replace what stands between the marks in docs/scaling.md."""
    page = PAGE.read_text(encoding="utf-8")
    before, rest = page.split(BEGIN)
    after = rest.split(END)[1]
    PAGE.write_text(f"{before}{BEGIN}\n{text}\n{END}{after}", encoding="utf-8")


def main() -> None:
    """Measure, print, and write if asked to."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", type=int, nargs="?", default=len(HIDDEN))
    parser.add_argument("--write", action="store_true", help="put the tables into docs/scaling.md")
    chosen = parser.parse_args()
    with TemporaryDirectory() as folder:
        joints = [
            make_joint(Path(folder) / str(k), hidden, SEED + k)
            for k, hidden in enumerate(islice(cycle(HIDDEN), chosen.cases))
        ]
        solve_alone(joints[0])  # fills the cache of compiled kernels
        costs = list(map(solve_alone, joints))
        text = report(costs, count_traffic(joints[-1]))
    print(text)
    if chosen.write:
        write_page(text)


if __name__ == "__main__":
    main()
