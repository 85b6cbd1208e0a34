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
from server.api.body_limit import BodyLimit
from server.api.dependencies import authenticate
from server.api.pages import docs_page
from server.api.routers import access, discrepancies, events, health, leases, models, recordings, rigs
from server.services.container import Services, open_services
from server.services.settings import ServiceSettings

STORE = (recordings.router, models.router, discrepancies.router)
ROUTERS = (rigs.router, leases.router, events.router, access.router, *STORE)
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
    api = APIRouter(prefix="/api/v1", dependencies=[Depends(authenticate)])
    for router in ROUTERS:
        api.include_router(router)
    app.include_router(api)
    app.include_router(health.router)
    app.add_middleware(BodyLimit, upload_octets=settings.max_upload_octets)
    problems.install(app)
    openapi.install(app)

    @app.get("/docs", response_class=HTMLResponse, include_in_schema=False)
    async def docs() -> HTMLResponse:
        """Show the API in words."""
        return HTMLResponse(docs_page(app.openapi()))

    return app
