"""The operator's lease of a rig: take, renew, give back."""

import time

from fastapi import APIRouter

from server.api.dependencies import LeaseDep, ReadDep, RigDep, RunDep, ServicesDep
from server.api.schemas.rigs import LeaseAnswer, LeaseBody, LeaseGranted, LeaseRenewal
from server.services.errors import NotFoundError
from server.services.rigs.lease import Grant

router = APIRouter(prefix="/rigs/{rig_id}/lease", tags=["leases"])


@router.get("")
def read_lease(rig: RigDep, who: ReadDep) -> LeaseAnswer:
    """Tell who holds the rig; 404 when nobody does."""
    lease = rig.lease.view()
    if lease is None:
        raise NotFoundError("live lease", rig.id, "nobody holds this rig: POST here takes its lease")
    return LeaseAnswer.model_validate(lease)


@router.post("", status_code=201)
def take_lease(rig: RigDep, body: LeaseBody, who: RunDep, services: ServicesDep) -> LeaseGranted:
    """Take the lease; with `take_over` also from its holder, after the drive has ramped down."""
    action = "lease.take_over" if body.take_over else "lease.acquire"
    with services.audit.record(who, action, f"rigs/{rig.id}", ttl_s=body.ttl_s):
        take = rig.take_over if body.take_over else rig.acquire
        return _granted(take(who, body.ttl_s))


@router.put("")
def renew_lease(rig: RigDep, body: LeaseRenewal, who: RunDep, lease: LeaseDep) -> LeaseGranted:
    """Hold on to the lease; call it every third of its length."""
    return _granted(rig.lease.renew(lease, body.ttl_s))


@router.delete("", status_code=204)
def release_lease(rig: RigDep, who: RunDep, lease: LeaseDep, services: ServicesDep) -> None:
    """Give the rig back; what it is at ramps down."""
    with services.audit.record(who, "lease.release", f"rigs/{rig.id}"):
        rig.release(lease)


def _granted(grant: Grant) -> LeaseGranted:
    return LeaseGranted(
        id=grant.id,
        holder=grant.holder,
        ttl_s=grant.ttl_s,
        expires_in_s=max(0.0, grant.ends_s - time.monotonic()),
    )
