"""Health, readiness, metrics and the plain status page: no token, and nothing that anybody could use."""

from fastapi import APIRouter
from fastapi.responses import HTMLResponse, PlainTextResponse, Response
from prometheus_client import CONTENT_TYPE_LATEST, CollectorRegistry, generate_latest
from pydantic import Field

from server.api.dependencies import ServicesDep
from server.api.metrics import ServiceCollector
from server.api.pages import status_page
from server.api.schemas.base import Answer
from server.services.errors import ClosingError

router = APIRouter(tags=["health"])


class Health(Answer):
    """Alive."""

    status: str = Field(examples=["ok"])


@router.get("/healthz")
async def healthz() -> Health:
    """Tell that the process answers."""
    return Health(status="ok")


@router.get("/readyz")
def readyz(services: ServicesDep) -> Health:
    """Tell that the service can work: the database answers and nobody is shutting it down."""
    if services.closing.is_set():
        raise ClosingError("the service is shutting down", "wait until it is started again")
    services.events.newest_id()
    return Health(status="ready")


@router.get("/metrics", response_class=PlainTextResponse)
def metrics(services: ServicesDep) -> Response:
    """Give figures for Prometheus."""
    registry = CollectorRegistry(auto_describe=False)
    registry.register(ServiceCollector(services))
    return Response(generate_latest(registry), media_type=CONTENT_TYPE_LATEST)


@router.get("/", response_class=HTMLResponse, include_in_schema=False)
async def status() -> HTMLResponse:
    """Show that the service is there, and where its documentation is."""
    return HTMLResponse(status_page())
