"""Close the loop on the rig: play the experiment that an answer proposes, add its record, ask again.

Every proposal is planned like any campaign first (limits of the rig file, travel, heat, line); the drive is on only
inside its record. Each round has a folder of its own below the answer's, where the last round's answer is copied to.
"""

import json
import math
import shutil
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from server.errors import CampaignStoppedError, InputError, InputLocation
from server.services.campaign import how_it_ended, run_campaign
from server.services.discrepancy import (
    ANSWER_NAMES,
    EXPERIMENT_NAME,
    GapAnalysis,
    GapRequest,
    run_gap_analysis,
)
from server.services.loading import RunChoices, load_plan, load_rig
from server.services.plan import CampaignPlan
from server.services.progress import ProgressListener
from server.services.run_folder import RECORDS

if TYPE_CHECKING:
    from discrepancy.result import GapResult

SCHEMA = "jointscope.resolve/1"
RESOLVE_NAME = "resolve.json"
SHORTEST_S = 5.0
"""A rest of the budget below this is not worth a record."""
SIZE_ERROR = 1.3
"""A strength that is seen is predicted by linearisation, and good to about this factor."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ResolveRequest:
    """What to ask, and which rig may be used for it.

    Attributes:
        gap: model and the records there are.
        rig: rig file.
        emulate: scenario to emulate instead of the rig file's port.
        speed: of the emulated controller.
        budget_s: rig time that may be spent, s.
        rounds: most experiments.
    """

    gap: GapRequest
    rig: Path
    emulate: Path | None = None
    speed: str | None = None
    budget_s: float = 300.0
    rounds: int = 4


@dataclass(slots=True)
class Resolution:
    """How far it came; `ended` says why there was no further round."""

    rounds: list[dict[str, Any]] = field(default_factory=list)  # Any: values of the JSON file
    spent_s: float = 0.0
    ended: str = "running"
    message: str = ""

    @property
    def is_settled(self) -> bool:
        """Whether nothing was left that an experiment could settle."""
        return self.ended == "settled"

    def write(self, out: Path) -> None:
        """Write `resolve.json`."""
        content = {
            "schema": SCHEMA,
            "ended": self.ended,
            "message": self.message,
            "rig_time_s": self.spent_s,
            "rounds": self.rounds,
        }
        (out / RESOLVE_NAME).write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def resolve(
    request: ResolveRequest, out: Path, listener: ProgressListener, stop: threading.Event
) -> tuple[GapAnalysis, Resolution]:
    """Ask, play what is proposed, and ask again.

    Args:
        request: question, rig and budget.
        out: folder for the answer; each round has its own below it.
        listener: told what happens.
        stop: set it to end; a drive that is on comes to rest first.

    Raises:
        InputError: model, recordings or rig do not allow it.
        CampaignStoppedError: stopped; finished rounds stand in the folder.
        RigTrippedError, RunFailedError, DaqError: as `run_campaign` does.
    """
    out.mkdir(parents=True, exist_ok=True)
    _refuse_earlier(out)
    done = Resolution()
    try:
        analysis = _loop(request, out, (listener, stop), done)
    except BaseException as error:
        done.ended, done.message = how_it_ended(error).value, " ".join(str(error).split())
        raise
    finally:
        done.write(out)
    return analysis, done


def _refuse_earlier(out: Path) -> None:
    if (out / RESOLVE_NAME).exists() or (out / "round-0").exists():
        raise InputError(
            "holds the rounds of an earlier call; choose another folder with --out", InputLocation(source=out)
        )


def _loop(
    request: ResolveRequest, out: Path, rest: tuple[ProgressListener, threading.Event], done: Resolution
) -> GapAnalysis:
    listener, stop = rest
    rig = load_rig(request.rig, emulate=request.emulate, speed=request.speed)
    gap = replace(request.gap, rig=rig, stop=stop)
    while True:
        folder = out / f"round-{len(done.rounds)}"
        left_s = request.budget_s - done.spent_s
        longest_s = max(SHORTEST_S, min(gap.longest_s, left_s))
        analysis = run_gap_analysis(replace(gap, longest_s=longest_s), folder, listener.note)
        done.rounds.append(_summary(analysis, gap, done.spent_s))
        _copy_answer(analysis, out)
        done.write(out)
        done.ended, done.message = _end(analysis, request, done)
        if done.ended != "running" or analysis.experiment is None:
            return replace(analysis, folder=out, experiment=_copied(out, analysis.experiment))
        if stop.is_set():
            raise CampaignStoppedError("stopped before the next experiment")
        record = _play(request, analysis.experiment, folder, (listener, stop, done))
        gap = replace(gap, train=(*gap.train, record))


def _play(
    request: ResolveRequest,
    experiment: Path,
    folder: Path,
    rest: tuple[ProgressListener, threading.Event, Resolution],
) -> Path:
    """Plan the proposed campaign, play it, and return its recording."""
    listener, stop, done = rest
    choices = RunChoices(campaign=experiment, rig=request.rig, emulate=request.emulate, speed=request.speed)
    plan = load_plan(choices)
    listener.note(f"experiment {len(done.rounds)}: {plan.campaign.description}")
    _play_plan(plan, folder / "run", (listener, stop))
    done.spent_s += plan.duration_s
    return folder / "run" / RECORDS / f"{_record_name(plan)}.parquet"


def _play_plan(plan: CampaignPlan, folder: Path, rest: tuple[ProgressListener, threading.Event]) -> None:
    listener, stop = rest
    result = run_campaign(plan, folder, listener, stop)
    result.manifest.write(folder)


def _record_name(plan: CampaignPlan) -> str:
    return next(planned.step.name for planned in plan.steps if planned.step.step == "record")


def _end(analysis: GapAnalysis, request: ResolveRequest, done: Resolution) -> tuple[str, str]:
    """Return why this was the last round; `running` if it was not."""
    result = analysis.result
    if analysis.experiment is None:
        return _without_proposal(result.verdict, result.next_experiment)
    if result.verdict == "none" and _has_shown(result, done.rounds[:-1]):
        told = "a record that would have shown every effect from its stated strength on has shown none"
        return "settled", f"nothing is open: {told}"
    if len(done.rounds) > request.rounds:
        return "rounds", f"{request.rounds} experiments were played and a question is left open"
    if request.budget_s - done.spent_s < SHORTEST_S:
        told = (
            f"{done.spent_s:g} s of {request.budget_s:g} s of rig time are spent and a question is left open"
        )
        return "budget", told
    asked = [one["experiment"]["excitation"] for one in done.rounds[:-1] if one["experiment"]]
    plan = result.next_experiment or {}
    if asked.count(plan.get("excitation")) > 1:
        return "stuck", "the same excitation was played twice and its question is still open"
    return "running", ""


def _has_shown(result: "GapResult", earlier: Sequence[Mapping[str, Any]]) -> bool:
    """Return whether a record that was to show hidden effects shows them from the strengths on that it was to."""
    stated = [one["experiment"].get("reveals") for one in earlier if one["experiment"]]
    seen = {one.id: abs(one.size) for one in result.pictures.detectable}
    return any(
        all(seen.get(one["effect"], math.inf) <= SIZE_ERROR * abs(one["then"]) for one in reveals)
        for reveals in stated
        if reveals
    )


def _without_proposal(verdict: str, left: Mapping[str, Any] | None) -> tuple[str, str]:
    if left is not None:
        return "measurement", "what is left open no motion settles: another measurement would"
    if verdict == "unknown":
        return (
            "unknown",
            "something is left that no effect of the catalogue explains: there are no rivals to separate",
        )
    return "settled", "nothing is open"


def _summary(analysis: GapAnalysis, gap: GapRequest, spent_s: float) -> dict[str, Any]:
    """Return a round's line of the table."""
    result = analysis.result
    effects = [
        {
            "id": step.added,
            "equivalents": [one if isinstance(one, str) else list(one) for one in step.equivalents],
            "parameters": {
                name: {"value": quantity.value, "std": quantity.std}
                for name, quantity in step.parameters.items()
                if not quantity.fixed
            },
        }
        for step in result.steps[1:]
    ]
    return {
        "folder": analysis.folder.name,
        "records": [str(path) for path in gap.train],
        "rig_time_s": spent_s,
        "verdict": result.verdict,
        "effects": effects,
        "gap_after": result.gap_after,
        "experiment": None if analysis.experiment is None else dict(result.next_experiment or {}),
    }


def _copy_answer(analysis: GapAnalysis, out: Path) -> None:
    """Put the newest answer where that of a plain `jointscope gap` stands."""
    (out / EXPERIMENT_NAME).unlink(missing_ok=True)
    for name in (*ANSWER_NAMES, EXPERIMENT_NAME):
        source = analysis.folder / name
        if source.exists():
            shutil.copyfile(source, out / name)


def _copied(out: Path, experiment: Path | None) -> Path | None:
    return None if experiment is None else out / experiment.name
