"""What is asked of an analysis, and what is told of it."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any

from server.services.errors import NotFoundError
from server.storage.states import JobState
from server.storage.tables import DiscrepancyRow

Json = dict[str, Any]  # JSON values


@dataclass(frozen=True, slots=True, kw_only=True)
class AnalysisRequest:
    """What to ask.

    Attributes:
        model: id of a model version.
        train: ids of recordings that may be fitted.
        test: ids of recordings that only score.
    """

    model: str
    train: list[str]
    test: list[str]


@dataclass(frozen=True, slots=True, kw_only=True)
class AnalysisView:
    """One analysis.

    Attributes:
        reason: why it did not end well.
        progress: `text`, `fits` and `elapsed_s` while it runs.
        result: the heart of `gap.json`, once done.
        model_id: the extended model, once done.
    """

    id: str
    state: JobState
    reason: str
    request: AnalysisRequest
    progress: Json
    result: Json
    model_id: str | None
    created_by: str
    created_at: datetime
    started_at: datetime | None
    ended_at: datetime | None


def find_row(row: DiscrepancyRow | None, analysis_id: str) -> DiscrepancyRow:
    """Return the row.

    Raises:
        NotFoundError: there is none of this id.
    """
    if row is None:
        raise NotFoundError(
            "discrepancy analysis", analysis_id, "GET /api/v1/discrepancies lists those that there are"
        )
    return row


def view_of(row: DiscrepancyRow) -> AnalysisView:
    """Return what is told of an analysis."""
    return AnalysisView(
        id=row.id,
        state=JobState(row.state),
        reason=row.reason or "",
        request=AnalysisRequest(**row.request),
        progress=row.progress or {},
        result=row.result or {},
        model_id=row.model_id,
        created_by=row.created_by,
        created_at=row.created_at,
        started_at=row.started_at,
        ended_at=row.ended_at,
    )
