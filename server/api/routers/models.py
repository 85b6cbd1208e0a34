"""Joint models: versions, and what each came from."""

from typing import Annotated

from fastapi import APIRouter, Path, Query, Request
from fastapi.responses import Response
from starlette.concurrency import run_in_threadpool

from server.api.bodies import YAML_TYPE, document_body, read_body
from server.api.dependencies import ReadDep, RunDep, ServicesDep
from server.api.schemas.models import ModelAnswer, ModelList
from server.services.models import NewModel, Source, SourceKind

router = APIRouter(prefix="/models", tags=["models"])
MAX_OFFSET = 10**9
ModelId = Annotated[str, Path(description="Id of a model version.", max_length=40)]
Offset = Annotated[int, Query(ge=0, le=MAX_OFFSET, description="`next_offset` of the page before.")]
_EXAMPLE = """name: joint1
outputs: [speed_rad_s]
parameters:
  inertia: {value: 0.5, unit: kg m^2, fixed: true}
  viscous_friction: {value: 0.9, unit: N m s/rad}
  torque_constant: {value: 1.0, unit: N m/A}
"""


@router.get("")
def list_models(
    services: ServicesDep,
    who: ReadDep,
    name: Annotated[str | None, Query(max_length=120, description="Only versions of this model.")] = None,
    source: Annotated[
        str | None, Query(max_length=40, description="Only what came from this recording, analysis or model.")
    ] = None,
    offset: Offset = 0,
    limit: Annotated[int, Query(ge=1, le=500)] = 100,
) -> ModelList:
    """List model versions, newest first."""
    found = services.models.page(name=name, source=source, offset=offset, limit=limit + 1)
    items = [ModelAnswer.model_validate(each) for each in found[:limit]]
    return ModelList(items=items, next_offset=offset + limit if len(found) > limit else None)


@router.post(
    "",
    status_code=201,
    openapi_extra=document_body(YAML_TYPE, "application/json", schema={"type": "object"}, example=_EXAMPLE),
)
async def upload_model(
    request: Request,
    services: ServicesDep,
    who: RunDep,
    note: Annotated[str, Query(max_length=1000, description="What is new in it.")] = "",
    parent: Annotated[str | None, Query(max_length=40, description="The version it was made of.")] = None,
) -> ModelAnswer:
    """Upload a model file, YAML or JSON; it becomes the next version of the model that it names."""
    octets = await read_body(request)

    def add() -> ModelAnswer:
        lineage: tuple[Source, ...] = ()
        if parent is not None:
            lineage = (Source(kind=SourceKind.MODEL, id=services.models.get(parent).id),)
        with services.audit.record(who, "model.upload", "models") as details:
            new = NewModel(document={}, note=note, created_by=who.name, lineage=lineage)
            added = services.models.add_text(octets, new)
            details["id"] = added.id
        return ModelAnswer.model_validate(added)

    return await run_in_threadpool(add)


@router.get("/{model_id}")
def read_model(model_id: ModelId, services: ServicesDep, who: ReadDep) -> ModelAnswer:
    """Read one version."""
    return ModelAnswer.model_validate(services.models.get(model_id))


@router.get(
    "/{model_id}/file",
    response_class=Response,
    responses={
        200: {"content": {YAML_TYPE: {"schema": {"type": "object"}}}, "description": "The model file."}
    },
)
def read_model_file(model_id: ModelId, services: ServicesDep, who: ReadDep) -> Response:
    """Read one version as the YAML file that `jointscope gap --model` takes."""
    return Response(services.models.text(model_id), media_type=YAML_TYPE)
