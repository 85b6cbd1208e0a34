"""What routers are given: the services, who asks, and the lease that a request shows.

    @router.post("/rigs/{rig_id}/capture")
    def start(rig: RigDep, who: RunDep, lease: LeaseDep, services: ServicesDep) -> CaptureStarted:

Endpoints are plain `def`: they run in threads, so that a call that waits for a controller never holds up the event
loop.
"""

import asyncio
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Annotated

from fastapi import Depends, Header, Path
from fastapi.security import HTTPBearer
from starlette.requests import HTTPConnection
from starlette.types import Scope as StarletteScope

from server.api.problems import FORBIDDEN, Kind, ProblemError
from server.services.container import Services
from server.services.rigs.served_rig import ServedRig
from server.services.tokens import Principal, Scope

LEASE_HEADER = "Jointscope-Lease"
# For the document alone: the gate (server/api/gate.py) reads the header.
BEARER = HTTPBearer(auto_error=False, description="A token of `jointscope token create`.")
_NO_LEASE = Kind(
    name="lease",
    title="The rig's lease is not yours",
    status=409,
    remedy=f"POST /api/v1/rigs/RIG/lease, then send its id as the header {LEASE_HEADER}",
)


def get_services(connection: HTTPConnection) -> Services:
    """Return the services of the application."""
    services: Services = connection.app.state.services
    return services


def get_urgent(connection: HTTPConnection) -> ThreadPoolExecutor:
    """Return the threads kept free for authentication and e-stop, however busy the others are."""
    urgent: ThreadPoolExecutor = connection.app.state.urgent
    return urgent


ServicesDep = Annotated[Services, Depends(get_services)]
UrgentDep = Annotated[ThreadPoolExecutor, Depends(get_urgent)]


async def authenticate(connection: HTTPConnection) -> Principal:
    """Return who asks; the gate has found out before anything of the request was read."""
    principal: Principal = connection.state.principal
    return principal


def require(scope: Scope) -> Callable[..., Awaitable[Principal]]:
    """Return a dependency that lets only tokens with `scope` pass and gives the principal."""

    async def check(
        connection: HTTPConnection,
        principal: Annotated[Principal, Depends(authenticate)],
        services: ServicesDep,
        urgent: UrgentDep,
    ) -> Principal:
        if not principal.may(scope):
            await asyncio.get_running_loop().run_in_executor(
                urgent, _note_refusal, services, principal, connection.scope, scope
            )
            allowed = ", ".join(sorted(principal.scopes))
            raise ProblemError(
                FORBIDDEN, f"this needs the scope {scope}; the token {principal.name!r} has {allowed}"
            )
        return principal

    return check


def _note_refusal(services: Services, who: Principal, asked: StarletteScope, needed: Scope) -> None:
    method = str(asked.get("method", "WEBSOCKET"))
    details = {"method": method, "scope": needed.value}
    services.audit.write(who, "refused", str(asked["path"])[:200], f"403: needs {needed}", details)


ReadDep = Annotated[Principal, Depends(require(Scope.READ))]
RunDep = Annotated[Principal, Depends(require(Scope.RUN))]
ArmDep = Annotated[Principal, Depends(require(Scope.ARM))]
AdminDep = Annotated[Principal, Depends(require(Scope.ADMIN))]


async def find_rig(
    services: ServicesDep, rig_id: Annotated[str, Path(description="The rig's id.", examples=["emulated"])]
) -> ServedRig:
    """Return the rig that the path names; asynchronous, so that e-stop waits for no thread."""
    return services.rigs.get(rig_id)


RigDep = Annotated[ServedRig, Depends(find_rig)]


def check_lease(
    rig: RigDep,
    lease_id: Annotated[
        str | None, Header(alias=LEASE_HEADER, description="Id of the operator's lease of this rig.")
    ] = None,
) -> str:
    """Return the id of the live lease that the request shows.

    Raises:
        ProblemError: it shows none.
        LeaseError: the lease has ended, or is somebody else's.
    """
    if lease_id is None:
        raise ProblemError(_NO_LEASE, "this needs the operator's lease of the rig", field=LEASE_HEADER)
    rig.lease.check(lease_id)
    return lease_id


LeaseDep = Annotated[str, Depends(check_lease)]
