"""One joint of a fleet as a task for another process, on this machine or another: files in, answer files out.

On a cluster the bytes of the files travel with the task, so that no file system has to be shared.
"""

import resource
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from server.errors import InputError
from server.services.fleet_list import FleetJoint

PLOTLY_NAME = "plotly.min.js"


@dataclass(frozen=True, slots=True, kw_only=True)
class JointJob:
    """What to solve; `contents` holds the files by number where the worker cannot read them."""

    joint: FleetJoint
    contents: tuple[bytes, ...] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class JointAnswer:
    """What came of one joint.

    Attributes:
        entry: its line of `fleet.json`; has the key `error` where there is no answer.
        files: answer files by name.
    """

    entry: Mapping[str, Any]
    files: Mapping[str, bytes] = field(default_factory=dict)

    @property
    def failed(self) -> bool:
        """Whether there is no answer."""
        return self.entry.get("error") is not None


def pack(joint: FleetJoint) -> JointJob:
    """Return the task with its files' contents.

    Raises:
        OSError: a file cannot be read.
    """
    return JointJob(joint=joint, contents=tuple(path.read_bytes() for path in joint.files))


def solve_joint(job: JointJob) -> JointAnswer:
    """Analyse one joint; never raises for what is wrong with that joint alone."""
    from server.services.workers import hold_one_thread

    hold_one_thread()
    begin_s = time.process_time()
    with TemporaryDirectory(prefix="jointscope-") as folder:
        try:
            answer = _solve(job, Path(folder))
        except Exception as error:  # noqa: BLE001  # one joint must not stop the others
            answer = JointAnswer(
                entry={"joint": job.joint.joint, "error": _describe(error, job, Path(folder))}
            )
    peak_bytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    costs = {"cpu_s": round(time.process_time() - begin_s, 3), "peak_memory_bytes": peak_bytes}
    return JointAnswer(entry={**answer.entry, **costs}, files=answer.files)


def _solve(job: JointJob, folder: Path) -> JointAnswer:
    from server.services.discrepancy import GapRequest, analyse

    here = _unpack(job, folder)
    request = GapRequest(model=here.model, train=here.train, test=here.test)
    analysis = analyse(request, folder / "out", lambda _: None, None)
    result = analysis.result
    files = {
        path.name: _original_names(path.read_text(encoding="utf-8"), job, folder).encode()
        for path in analysis.files
    }
    files["report.html"] = share_plotly(files["report.html"].decode()).encode()
    entry = {
        "joint": job.joint.joint,
        "error": None,
        "verdict": result.verdict,
        "effects": list(result.effects),
        "equivalents": [
            one if isinstance(one, str) else list(one) for step in result.steps for one in step.equivalents
        ],
        "parameter_changes": {
            change.parameter: [change.nameplate, change.estimate] for change in result.parameter_changes
        },
        "gap_before": result.gap_before,
        "gap_after": result.gap_after,
        "gap_closed": result.gap_closed,
        "open_question": analysis.experiment is not None,
        "notes": [_original_names(note, job, folder) for note in result.notes],
    }
    return JointAnswer(entry=entry, files=files)


def _unpack(job: JointJob, folder: Path) -> FleetJoint:
    """Return the joint with paths that can be read here."""
    if job.contents is None:
        return job.joint
    paths = _unpacked_paths(job, folder)
    for path, content in zip(paths, job.contents, strict=True):
        path.parent.mkdir()
        path.write_bytes(content)
    split = 1 + len(job.joint.train)
    return FleetJoint(
        joint=job.joint.joint, model=paths[0], train=tuple(paths[1:split]), test=tuple(paths[split:])
    )


def _unpacked_paths(job: JointJob, folder: Path) -> list[Path]:
    return [folder / str(number) / path.name for number, path in enumerate(job.joint.files)]


def _original_names(text: str, job: JointJob, folder: Path) -> str:
    """Replace the names of unpacked files by those that the user knows, also where a drawing has escaped them."""
    for here, there in zip(_unpacked_paths(job, folder), job.joint.files, strict=True):
        for slash in ("/", "\\u002f", "\\/"):
            text = text.replace(str(here).replace("/", slash), str(there).replace("/", slash))
    return text


def _describe(error: Exception, job: JointJob, folder: Path) -> str:
    text = " ".join(_original_names(str(error), job, folder).split())
    expected = isinstance(error, (InputError, OSError))
    return text if expected else f"internal error: {type(error).__name__}: {text}"


def share_plotly(page: str) -> str:
    """Return a report that loads the drawing library from the fleet's folder, instead of carrying 5 MB of it."""
    from plotly.offline import get_plotlyjs

    library = get_plotlyjs()
    at = page.find(library)
    if at < 0:
        return page
    begin, end = page.rfind("<script", 0, at), page.find("</script>", at + len(library))
    return f'{page[:begin]}<script src="../{PLOTLY_NAME}">{page[end:]}'
