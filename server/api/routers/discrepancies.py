"""Discrepancy analyses: what does a model lack, judged by recordings? Background jobs with progress and a report."""

from typing import Annotated

from fastapi import APIRouter, Path, Query
from fastapi.responses import FileResponse

from server.api.dependencies import ReadDep, RunDep, ServicesDep
from server.api.schemas.models import DiscrepancyAnswer, DiscrepancyBody, DiscrepancyList
from server.services.analyses.answer import GAP_NAME, REPORT_NAME
from server.services.analyses.records import AnalysisRequest

router = APIRouter(prefix="/discrepancies", tags=["discrepancies"])
AnalysisId = Annotated[str, Path(description="The analysis' id.", max_length=40)]
# The report draws with the script that it carries. The sandbox gives it no origin, so it could reach nothing of ours.
REPORT_POLICY = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'self'"
)
_HEADERS = {
    "Content-Security-Policy": REPORT_POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
}


@router.get("")
def list_discrepancies(
    services: ServicesDep,
    who: ReadDep,
    model: Annotated[str | None, Query(max_length=40, description="The one that made this model.")] = None,
    offset: Annotated[int, Query(ge=0, le=10**9)] = 0,
    limit: Annotated[int, Query(ge=1, le=500)] = 100,
) -> DiscrepancyList:
    """List analyses, newest first."""
    found = services.analyses.page(model_id=model, offset=offset, limit=limit + 1)
    items = [DiscrepancyAnswer.model_validate(each) for each in found[:limit]]
    return DiscrepancyList(items=items, next_offset=offset + limit if len(found) > limit else None)


@router.post("", status_code=202)
def start_discrepancy(body: DiscrepancyBody, services: ServicesDep, who: RunDep) -> DiscrepancyAnswer:
    """Queue an analysis; one runs at a time, for a minute or more. Ask for it by its id to see how far it is."""
    request = AnalysisRequest(**body.model_dump())
    with services.audit.record(who, "discrepancy.start", "discrepancies", **body.model_dump()) as details:
        queued = services.analyses.submit(request, who.name)
        details["id"] = queued.id
    return DiscrepancyAnswer.model_validate(queued)


@router.get("/{analysis_id}")
def read_discrepancy(analysis_id: AnalysisId, services: ServicesDep, who: ReadDep) -> DiscrepancyAnswer:
    """Tell how far an analysis is, or what it found."""
    return DiscrepancyAnswer.model_validate(services.analyses.get(analysis_id))


@router.post("/{analysis_id}/cancel")
def cancel_discrepancy(analysis_id: AnalysisId, services: ServicesDep, who: RunDep) -> DiscrepancyAnswer:
    """End an analysis, whether it waits or runs."""
    with services.audit.record(who, "discrepancy.cancel", f"discrepancies/{analysis_id}"):
        return DiscrepancyAnswer.model_validate(services.analyses.cancel(analysis_id))


@router.get(
    "/{analysis_id}/gap",
    response_class=FileResponse,
    responses={
        200: {"content": {"application/json": {"schema": {"type": "object"}}}, "description": "gap.json"}
    },
)
def read_gap(analysis_id: AnalysisId, services: ServicesDep, who: ReadDep) -> FileResponse:
    """Read the whole answer, as `jointscope gap` writes it."""
    return FileResponse(services.analyses.file(analysis_id, GAP_NAME), media_type="application/json")


@router.get(
    "/{analysis_id}/report",
    response_class=FileResponse,
    responses={200: {"content": {"text/html": {"schema": {"type": "string"}}}, "description": "The report."}},
)
def read_report(analysis_id: AnalysisId, services: ServicesDep, who: ReadDep) -> FileResponse:
    """Read the report: one page that carries all it needs."""
    return FileResponse(
        services.analyses.file(analysis_id, REPORT_NAME), media_type="text/html", headers=_HEADERS
    )
