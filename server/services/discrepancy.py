"""Ask recordings what a joint's model lacks, and write the answer: gap.json, model.yaml, report.html."""

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from daq.errors import RecordingError
from daq.recording.derived_speed import SPEED_OF, with_speed
from daq.recording.recording import Recording, cut
from daq.recording.timebase import analyse_time_base, to_uniform
from server.config.rig import Rig
from server.errors import InputError, InputLocation
from server.services.dataset import driven_span
from server.services.exchange import open_recording
from server.services.executors import open_executor
from server.services.rehearsal import LONGEST_S, design_limits
from server.services.workers import hold_one_thread

if TYPE_CHECKING:
    from discrepancy.model.schema import JointModel
    from discrepancy.result import GapResult

ANSWER_NAMES = ("gap.json", "model.yaml", "report.html")
EXPERIMENT_NAME = "next_campaign.yaml"
WORKFLOW = "discrepancy.workflow"


@dataclass(frozen=True, slots=True, kw_only=True)
class GapRequest:
    """What to ask.

    Attributes:
        model: model file with the nameplate values.
        train: recordings that may be fitted; two with the same input show the noise.
        test: recordings that only score.
        jobs: processes for the candidate fits; None takes one for each core.
        cluster: address of a Dask scheduler that does them instead; None stays on this machine.
        stop: set it to give up between two fits.
        rig: rig whose limits a proposed experiment keeps to; None takes what the recordings have shown safe.
        longest_s: longest record that may be proposed.
    """

    model: Path
    train: tuple[Path, ...]
    test: tuple[Path, ...]
    jobs: int | None = None
    cluster: str | None = None
    stop: threading.Event = field(default_factory=threading.Event)
    rig: Rig | None = None
    longest_s: float = LONGEST_S


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GapAnalysis:
    """A finished analysis and the files that hold it; `experiment` is None where nothing is open."""

    result: "GapResult"
    folder: Path
    experiment: Path | None

    @property
    def files(self) -> tuple[Path, ...]:
        """Return everything that was written."""
        written = tuple(self.folder / name for name in ANSWER_NAMES)
        return written if self.experiment is None else (*written, self.experiment)


def read_joint_model(path: Path) -> "JointModel":
    """Read a model file.

    Raises:
        InputError: no such file, or not a model; names file and field.
    """
    from discrepancy.errors import ModelFileError
    from discrepancy.model.reader import read_model

    if not path.is_file():
        raise InputError("no such model file; see config/models/", InputLocation(source=path))
    try:
        return read_model(path)
    except ModelFileError as error:
        raise InputError(str(error)) from error


def open_for_model(path: Path, model: "JointModel") -> Recording:
    """Open a recording, cut it to the time in which its excitation played, and derive a speed that it lacks.

    Raises:
        InputError: unreadable, or without what the speed is derived from.
    """
    recording = open_recording(path)
    try:
        span = driven_span(recording)
        if span is not None:
            recording = cut(recording, *span)
        wanted = [
            position
            for position, speed in SPEED_OF.items()
            if speed in model.outputs and speed not in recording.columns and position in recording.columns
        ]
        if wanted:
            base = analyse_time_base(recording.time_s)
            recording = with_speed(recording if base.uniform else to_uniform(recording, base.mean_step_s))
    except (RecordingError, ValueError) as error:
        raise InputError(str(error), InputLocation(source=path)) from error
    return recording


def run_gap_analysis(request: GapRequest, out: Path, tell: Callable[[str], None]) -> GapAnalysis:
    """Find what the model lacks and write the answer into `out`, on many processes.

    Args:
        request: model, recordings, processes.
        out: folder, created.
        tell: takes lines for the user; called from more than one thread.

    Raises:
        InputError: the model, the recordings or the cluster do not allow an answer.
        CampaignStoppedError: stopped.
    """
    read_joint_model(request.model)  # a mistake in it should show before processes start
    with open_executor(WORKFLOW, tell, request) as pool:
        return analyse(request, out, tell, pool)


def analyse(
    request: GapRequest, out: Path, tell: Callable[[str], None], executor: Executor | None
) -> GapAnalysis:
    """Find what the model lacks and write the answer into `out`.

    Args:
        request: model and recordings; where the work is done is up to `executor`.
        out: folder, created.
        tell: takes lines for the user.
        executor: does the candidate fits; None does them here, one after the other.

    Raises:
        InputError: the model or the recordings do not allow an answer.
    """
    from discrepancy.errors import GapInputError
    from discrepancy.report.files import write_result
    from discrepancy.workflow import GapOptions, run_gap

    hold_one_thread()
    model = read_joint_model(request.model)
    train = _open_all("train", request.train, model, tell)
    test = _open_all("test", request.test, model, tell)
    tell(f"recalibrating {model.name}, then trying every effect of the catalogue")
    names = _labels("train", request.train) | _labels("test", request.test)
    try:
        limits = None if request.rig is None else design_limits(request.rig, request.longest_s)
        result = run_gap(model, train, test, GapOptions(executor=executor, limits=limits))
    except GapInputError as error:
        raise InputError(_with_names(str(error), names)) from error
    result = result.with_names(names)
    write_result(result, out)
    return GapAnalysis(result=result, folder=out, experiment=_write_experiment(result, out))


def _open_all(
    part: str, paths: Sequence[Path], model: "JointModel", tell: Callable[[str], None]
) -> list[Recording]:
    found = []
    for path in paths:
        recording = open_for_model(path, model)
        tell(f"{part}: {path.name}: {recording.n:,} samples, {recording.duration_s:.6g} s")
        found.append(recording)
    return found


def _labels(part: str, paths: Sequence[Path]) -> dict[str, str]:
    """Return the file behind each of the workflow's own labels."""
    return {f"{part}[{index}]": str(path) for index, path in enumerate(paths)}


def _with_names(text: str, names: dict[str, str]) -> str:
    for label, name in names.items():
        text = text.replace(label, name)
    return text


def _write_experiment(result: "GapResult", out: Path) -> Path | None:
    """Write the proposed experiment as a campaign that `jointscope run` plays; None where no current would help."""
    import yaml

    from discrepancy.design.campaign import campaign

    path = out / EXPERIMENT_NAME
    path.unlink(missing_ok=True)
    if result.next_experiment is None or not result.next_experiment["excitation"]:
        return None
    content = campaign(result.next_experiment)
    path.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return path
