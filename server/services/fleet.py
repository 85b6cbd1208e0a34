"""Many joints in one go: every joint in a folder of its own, a summary of all, and a second call goes on.

A joint is one task; its analysis runs in one process from beginning to end. That wastes nothing as long as there are
more joints than processes. No more than twice as many joints are under way as there are processes: the rest waits in
its files, so that neither this process nor a cluster's scheduler holds a night's recordings in memory.
"""

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from server.errors import RunFailedError
from server.services.executors import open_executor
from server.services.fleet_folder import FleetFolder
from server.services.fleet_list import FleetJoint, read_fleet_list
from server.services.joint_job import JointAnswer, JointJob, pack, solve_joint

TASKS = "discrepancy.workflow"
"""Loaded once for all processes: it takes a second."""
SUMMARY_EVERY_S = 60.0
UNDER_WAY = 2
"""Joints handed out for each process: one is worked on, one is there when that is done."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetRequest:
    """What to do.

    Attributes:
        list_file: CSV file of the joints.
        out: folder for the answers.
        jobs: processes of this machine; None takes one for each core.
        cluster: address of a Dask scheduler that does the work instead.
        again: whether finished joints are done again.
        stop: set it to give up after the joints under way.
    """

    list_file: Path
    out: Path
    jobs: int | None = None
    cluster: str | None = None
    again: bool = False
    stop: threading.Event = field(default_factory=threading.Event)


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetOutcome:
    """What came of a fleet; `skipped` joints had been finished before."""

    folder: Path
    counts: dict[str, int]
    skipped: int


def run_fleet(request: FleetRequest, tell: Callable[[str], None]) -> FleetOutcome:
    """Analyse every joint of a list that is not finished.

    Args:
        request: list, folder, processes.
        tell: takes lines for the user.

    Raises:
        InputError: the list is wrong, or the cluster cannot be used. A joint's own mistake stands in the summary.
        RunFailedError: the cluster is gone; the summary holds what was finished.
    """
    joints = read_fleet_list(request.list_file)
    folder = FleetFolder(request.out, joints)
    waiting = [joint for joint in joints if request.again or not folder.is_finished(joint)]
    skipped = len(joints) - len(waiting)
    tell(f"{len(joints)} joints, {skipped} finished before, {len(waiting)} to do")
    if not waiting:
        return FleetOutcome(folder=request.out, counts=folder.write_summary(), skipped=skipped)
    with open_executor(TASKS, lambda _: None, request) as pool:
        progress = _Progress(tell=tell, total=len(waiting))
        prepare = pack if request.cluster is not None else _in_place
        try:
            for joint, answer in _solve_all(pool, pool.slots, waiting, prepare):
                folder.write_joint(joint, answer)
                progress.joint_done(answer)
                if progress.summary_due():
                    folder.write_summary()
        finally:
            counts = folder.write_summary()
    return FleetOutcome(folder=request.out, counts=counts, skipped=skipped)


def _in_place(joint: FleetJoint) -> JointJob:
    return JointJob(joint=joint)


def _solve_all(
    pool: Executor, slots: int, joints: Sequence[FleetJoint], prepare: Callable[[FleetJoint], JointJob]
) -> Iterator[tuple[FleetJoint, JointAnswer]]:
    """Yield each joint with its answer, in the order in which they are finished."""
    under_way: dict[Future[JointAnswer], FleetJoint] = {}
    remaining = iter(joints)
    while True:
        while len(under_way) < UNDER_WAY * slots and (joint := next(remaining, None)) is not None:
            try:
                under_way[pool.submit(solve_joint, prepare(joint))] = joint
            except OSError as error:
                yield joint, _failure(joint, f"{error.filename}: {error.strerror}")
        if not under_way:
            return
        for future in wait(under_way, return_when=FIRST_COMPLETED).done:
            yield under_way[future], _answer(under_way[future], future)
            del under_way[future]


def _answer(joint: FleetJoint, future: Future[JointAnswer]) -> JointAnswer:
    try:
        return future.result()
    except RunFailedError as error:  # its process died, again and again
        return _failure(joint, str(error))


def _failure(joint: FleetJoint, error: str) -> JointAnswer:
    return JointAnswer(entry={"joint": joint.joint, "error": error})


@dataclass(slots=True, kw_only=True)
class _Progress:
    """Tells one line for each joint, with the time that is left at the pace so far."""

    tell: Callable[[str], None]
    total: int
    done: int = 0
    begin_s: float = field(default_factory=time.monotonic)
    written_s: float = field(default_factory=time.monotonic)

    def joint_done(self, answer: JointAnswer) -> None:
        self.done += 1
        left = self.total - self.done
        left_s = (time.monotonic() - self.begin_s) / self.done * left
        rest = f"; {left} left, about {spoken_time(left_s)}" if left else ""
        self.tell(f"[{self.done}/{self.total}] {answer.entry['joint']}: {_gist(answer.entry)}{rest}")

    def summary_due(self) -> bool:
        now_s = time.monotonic()
        if now_s - self.written_s < SUMMARY_EVERY_S:
            return False
        self.written_s = now_s
        return True


def _gist(entry: Any) -> str:  # Any: a line of fleet.json
    if entry["error"] is not None:
        return f"error: {entry['error']}"
    names = ", ".join(entry["effects"])
    return f"{entry['verdict']}: {names}" if names else str(entry["verdict"])


def spoken_time(seconds: float) -> str:
    """Return a length of time in the unit that a person would use."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"
