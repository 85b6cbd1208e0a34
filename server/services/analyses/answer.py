"""What an analysis leaves: the heart of its answer, and the extended model as a version with its lineage."""

import json
from pathlib import Path

import yaml

from server.services.analyses.records import AnalysisView, Json
from server.services.models import ModelStore, NewModel, Source, SourceKind

GAP_NAME, REPORT_NAME, MODEL_NAME, INPUT_NAME = "gap.json", "report.html", "model.yaml", "input.yaml"
_SHOWN = (
    "verdict",
    "effects",
    "unknown",
    "parameter_changes",
    "gap_before",
    "gap_after",
    "gap_closed",
    "next_experiment",
)


def keep_answer(view: AnalysisView, folder: Path, models: ModelStore) -> tuple[Json, str]:
    """Make the extended model a version.

    Args:
        view: the analysis.
        folder: where its files are.
        models: takes the model.

    Returns:
        The heart of `gap.json`, and the id of the model's new version.
    """
    answer = json.loads((folder / GAP_NAME).read_text(encoding="utf-8"))
    document = yaml.safe_load((folder / MODEL_NAME).read_text(encoding="utf-8"))
    request = view.request
    lineage = [
        Source(kind=SourceKind.ANALYSIS, id=view.id),
        Source(kind=SourceKind.MODEL, id=request.model),
        *(Source(kind=SourceKind.RECORDING, id=each) for each in (*request.train, *request.test)),
    ]
    note = f"{answer['verdict']}: {', '.join(answer['effects']) or 'no effect added'}"
    new = NewModel(document=document, note=note, created_by=view.created_by, lineage=tuple(lineage))
    return {key: answer.get(key) for key in _SHOWN}, models.add(new).id
