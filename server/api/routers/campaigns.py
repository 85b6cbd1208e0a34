"""Campaigns and the queue of each rig."""

from typing import Annotated

from fastapi import APIRouter, Depends, Path, Query, Request, Response

from server.api.bodies import YAML_TYPE, document_body
from server.api.dependencies import ReadDep, RigDep, RunDep, ServicesDep
from server.api.job_filter import WantedDep
from server.api.schemas.jobs import CampaignAnswer, CampaignPage, ForecastAnswer, QueueAnswer, QueueBody
from server.config.submitted import read_document
from server.services.container import Services
from server.services.jobs.machine import Happening
from server.services.tokens import Principal

router = APIRouter(tags=["campaigns"])
CampaignId = Annotated[str, Path(max_length=40, description="The campaign's id.")]
_JSON = "application/json"
_EXAMPLE = """name: quick
steps:
  - record:
      name: train
      duration_s: 20
      excitation: {kind: multisine, amplitude_A: 0.8, period_s: 5, lines: 8, seed: 7, ramp_s: 0.5}
  - identify: {train: train, test: train, sample_time_s: 0.1}
"""


async def read_body(request: Request) -> tuple[str, bool]:
    """Return the document as text, and whether it is JSON."""
    is_json = request.headers.get("content-type", "").partition(";")[0].strip().lower() == _JSON
    return read_document(await request.body()), is_json


@router.post(
    "/campaigns",
    status_code=201,
    openapi_extra=document_body(YAML_TYPE, _JSON, schema={"type": "object"}, example=_EXAMPLE),
    response_model=CampaignAnswer | ForecastAnswer,
    responses={200: {"model": ForecastAnswer, "description": "Of a dry run."}},
)
def submit_campaign(
    who: RunDep,
    services: ServicesDep,
    body: Annotated[tuple[str, bool], Depends(read_body)],
    response: Response,
    rig: Annotated[str | None, Query(max_length=80, description="Instead of the document's own rig.")] = None,
    dry_run: Annotated[
        bool, Query(description="Check and predict every step; move and keep nothing.")
    ] = False,
) -> CampaignAnswer | ForecastAnswer:
    """Submit a campaign: the YAML that `jointscope run` takes (application/yaml), or the same as JSON.

    It is checked as a whole, then queued for its rig; the first in line begins when the rig is free.
    """
    text, is_json = body
    if dry_run:
        response.status_code = 200
        return ForecastAnswer.model_validate(services.campaigns.forecast(text, rig, is_json=is_json))
    with services.audit.record(who, "campaign.submit", "campaigns", rig=rig) as details:
        made = services.campaigns.submit(text, rig, who, is_json=is_json)
        details |= {"id": made.id, "name": made.name}
    return CampaignAnswer.model_validate(made)


@router.get("/campaigns")
def list_campaigns(services: ServicesDep, who: ReadDep, wanted: WantedDep) -> CampaignPage:
    """List campaigns, newest first: those that wait, run, and have ended."""
    found = services.campaigns.page(wanted)
    following = found[-1].id if len(found) == wanted.limit else None
    return CampaignPage(items=[CampaignAnswer.model_validate(each) for each in found], next_before=following)


@router.get("/campaigns/{campaign_id}")
def read_campaign(campaign_id: CampaignId, services: ServicesDep, who: ReadDep) -> CampaignAnswer:
    """Tell where a campaign and each of its steps stand."""
    return CampaignAnswer.model_validate(services.campaigns.get(campaign_id))


@router.get(
    "/campaigns/{campaign_id}/document",
    response_class=Response,
    responses={200: {"content": {YAML_TYPE: {"schema": {"type": "object"}}}, "description": "YAML"}},
)
def read_document_of_campaign(campaign_id: CampaignId, services: ServicesDep, who: ReadDep) -> Response:
    """Return the document as it was submitted."""
    path = services.campaigns.document(campaign_id)
    return Response(path.read_bytes(), media_type=YAML_TYPE)


@router.post("/campaigns/{campaign_id}/pause", status_code=202)
def pause_campaign(campaign_id: CampaignId, who: RunDep, services: ServicesDep) -> CampaignAnswer:
    """Bring the drive to rest and wait; a record under way is put aside and made anew on resume."""
    return _ask(campaign_id, Happening.PAUSE, who, services)


@router.post("/campaigns/{campaign_id}/resume", status_code=202)
def resume_campaign(campaign_id: CampaignId, who: RunDep, services: ServicesDep) -> CampaignAnswer:
    """Go on after a pause."""
    return _ask(campaign_id, Happening.RESUME, who, services)


@router.post("/campaigns/{campaign_id}/stop", status_code=202)
def stop_campaign(campaign_id: CampaignId, who: RunDep, services: ServicesDep) -> CampaignAnswer:
    """End the step under way in order and begin no other; one that waits is cancelled."""
    return _ask(campaign_id, Happening.STOP, who, services)


@router.post("/campaigns/{campaign_id}/abort", status_code=202)
def abort_campaign(campaign_id: CampaignId, who: RunDep, services: ServicesDep) -> CampaignAnswer:
    """As stop; the state then says that its recordings are not to be relied upon."""
    return _ask(campaign_id, Happening.ABORT, who, services)


@router.post("/campaigns/{campaign_id}/requeue", status_code=202)
def requeue_campaign(campaign_id: CampaignId, who: RunDep, services: ServicesDep) -> CampaignAnswer:
    """Queue a campaign again that has ended without being done: it begins with its first step, as yours."""
    with services.audit.record(who, "campaign.requeue", f"campaigns/{campaign_id}"):
        return CampaignAnswer.model_validate(services.campaigns.requeue(campaign_id, who))


@router.get("/rigs/{rig_id}/queue")
def read_queue(rig: RigDep, services: ServicesDep, who: ReadDep) -> QueueAnswer:
    """List the campaigns that wait for a rig."""
    return QueueAnswer.model_validate(services.campaigns.queue(rig.id))


@router.put("/rigs/{rig_id}/queue")
def arrange_queue(rig: RigDep, body: QueueBody, services: ServicesDep, who: RunDep) -> QueueAnswer:
    """Put the queue into another order, hold it, or release it."""
    with services.audit.record(who, "queue.arrange", f"rigs/{rig.id}/queue", **body.model_dump()):
        return QueueAnswer.model_validate(services.campaigns.arrange(rig.id, body.order, body.held))


def _ask(campaign_id: str, happening: Happening, who: Principal, services: Services) -> CampaignAnswer:
    with services.audit.record(who, f"campaign.{happening}", f"campaigns/{campaign_id}"):
        return CampaignAnswer.model_validate(services.campaigns.ask(campaign_id, happening))
