"""The application: routers, errors and services put together. `create_app(settings)` is all that a server needs.

A new resource: a router in `server/api/routers/`, an entry in `ROUTERS`, its records in `server/api/schemas/`, and its
service in `server/services/container.py`. Everything below /api/v1 is behind a token without any further word.
"""

import contextlib
from collections.abc import AsyncIterator
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import version

from fastapi import APIRouter, Depends, FastAPI
from fastapi.responses import HTMLResponse
from starlette.concurrency import run_in_threadpool

from server.api import openapi, problems
from server.api.dependencies import BEARER
from server.api.gate import Gate
from server.api.pages import docs_page
from server.api.routers import (
    access,
    campaigns,
    discrepancies,
    events,
    health,
    leases,
    live,
    models,
    recordings,
    rigs,
    session_live,
    sessions,
)
from server.services.container import Services, open_services
from server.services.settings import ServiceSettings

ROUTERS = (
    rigs.router,
    leases.router,
    live.router,
    sessions.router,
    campaigns.router,
    recordings.router,
    models.router,
    discrepancies.router,
    events.router,
    access.router,
)
SOCKETS = (live.sockets, session_live.sockets, events.sockets)
UPLOADS = ("/api/v1/recordings",)
_URGENT_THREADS = 8


def create_app(settings: ServiceSettings, services: Services | None = None) -> FastAPI:
    """Return the application.

    Args:
        settings: what whoever starts the service chose.
        services: opened already, and closed by the application at its end; None opens them at its start.
    """

    @contextlib.asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        opened = await run_in_threadpool(open_services, settings) if services is None else services
        app.state.services = opened
        app.state.urgent = ThreadPoolExecutor(_URGENT_THREADS, thread_name_prefix="jointscope-urgent")
        try:
            yield
        finally:
            opened.end_streams()
            await run_in_threadpool(opened.close)
            app.state.urgent.shutdown()

    app = FastAPI(
        title="Jointscope",
        version=version("jointscope"),
        lifespan=lifespan,
        docs_url=None,
        redoc_url=None,
        responses={},
    )
    api = APIRouter(prefix="/api/v1", dependencies=[Depends(BEARER)])
    for router in ROUTERS:
        api.include_router(router)
    app.include_router(api)
    for router in SOCKETS:
        app.include_router(router, prefix="/api/v1")
    app.add_middleware(Gate, uploads=UPLOADS)
    app.include_router(health.router)
    problems.install(app)
    openapi.install(app)

    @app.get("/docs", response_class=HTMLResponse, include_in_schema=False)
    async def docs() -> HTMLResponse:
        """Show the API in words."""
        return HTMLResponse(docs_page(app.openapi()))

    return app
