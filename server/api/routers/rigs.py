"""Rigs: connection, state, parameters, link, capture buffer, stop."""

import asyncio
from typing import Annotated

from fastapi import APIRouter, Path

from server.api.dependencies import ArmDep, LeaseDep, ReadDep, RigDep, RunDep, ServicesDep, UrgentDep
from server.api.schemas.rigs import (
    CaptureAnswer,
    CaptureBody,
    CaptureStarted,
    LinkAnswer,
    ParameterAnswer,
    ParameterList,
    ParameterWrite,
    RigAnswer,
    RigList,
)
from server.services.errors import LeaseError
from server.services.rigs.served_rig import ServedRig
from server.services.rigs.views import CaptureRequest
from server.services.tokens import Principal

router = APIRouter(prefix="/rigs", tags=["rigs"])
ParameterName = Annotated[str, Path(description="A controller parameter.", examples=["current_limit_A"])]


@router.get("")
def list_rigs(services: ServicesDep, who: ReadDep) -> RigList:
    """List all rigs."""
    return RigList(items=[RigAnswer.model_validate(rig.view()) for rig in services.rigs.all()])


@router.get("/{rig_id}")
def read_rig(rig: RigDep, who: ReadDep) -> RigAnswer:
    """Tell the state of one rig."""
    return RigAnswer.model_validate(rig.view())


@router.post("/{rig_id}/connect")
def connect(rig: RigDep, who: RunDep, services: ServicesDep) -> RigAnswer:
    """Open the rig's port and introduce ourselves; its drive stays off."""
    with services.audit.record(who, "rig.connect", f"rigs/{rig.id}"):
        return RigAnswer.model_validate(rig.connect())


@router.post("/{rig_id}/disconnect")
def disconnect(rig: RigDep, who: RunDep, services: ServicesDep) -> RigAnswer:
    """Give the rig's port back; refused while it is at work, or held by somebody else."""
    with services.audit.record(who, "rig.disconnect", f"rigs/{rig.id}"):
        _refuse_strangers(rig, who)
        return RigAnswer.model_validate(rig.disconnect())


@router.post("/{rig_id}/estop")
async def estop(rig: RigDep, who: ReadDep, services: ServicesDep, urgent: UrgentDep) -> RigAnswer:
    """Switch the drive off at once, and latch. Anybody who may read may do it; no lease is needed.

    A convenience beside a wired emergency stop, never instead of one.
    """
    loop = asyncio.get_running_loop()
    return await loop.run_in_executor(urgent, _estop, rig, who, services)


@router.post("/{rig_id}/clear-fault")
def clear_fault(rig: RigDep, who: ArmDep, lease: LeaseDep, services: ServicesDep) -> RigAnswer:
    """Leave a latched fault or safe state, once its cause is gone. See that the rig is safe before you do."""
    with services.audit.record(who, "rig.clear_fault", f"rigs/{rig.id}"):
        rig.clear_fault()
    return RigAnswer.model_validate(rig.view())


@router.get("/{rig_id}/parameters")
def list_parameters(rig: RigDep, who: ReadDep) -> ParameterList:
    """Read all parameters from the controller, with units and limits."""
    return ParameterList(items=[ParameterAnswer.model_validate(each) for each in rig.parameters()])


@router.get("/{rig_id}/parameters/{name}")
def read_parameter(rig: RigDep, name: ParameterName, who: ReadDep) -> ParameterAnswer:
    """Read one parameter from the controller."""
    return ParameterAnswer.model_validate(rig.parameter(name))


@router.put("/{rig_id}/parameters/{name}")
def write_parameter(
    rig: RigDep,
    name: ParameterName,
    body: ParameterWrite,
    who: RunDep,
    lease: LeaseDep,
    services: ServicesDep,
) -> ParameterAnswer:
    """Write one parameter; the answer holds the value now in force."""
    resource = f"rigs/{rig.id}/parameters/{name}"
    with services.audit.record(who, "rig.write_parameter", resource, value=body.value) as details:
        written = rig.write_parameter(name, body.value)
        details["in_force"] = written.value
    return ParameterAnswer.model_validate(written)


@router.get("/{rig_id}/link")
def read_link(rig: RigDep, who: ReadDep) -> LinkAnswer:
    """Tell how the link is doing."""
    return LinkAnswer.model_validate(rig.link_statistics())


@router.post("/{rig_id}/capture", status_code=202)
def start_capture(
    rig: RigDep, body: CaptureBody, who: RunDep, lease: LeaseDep, services: ServicesDep
) -> CaptureStarted:
    """Arm the controller's capture buffer: every tick around a trigger."""
    request = CaptureRequest(**body.model_dump())
    with services.audit.record(who, "rig.capture", f"rigs/{rig.id}", **body.model_dump()):
        return CaptureStarted(samples=rig.start_capture(request))


@router.get("/{rig_id}/capture")
def read_capture(rig: RigDep, who: ReadDep) -> CaptureAnswer:
    """Read the capture buffer; `complete` is false while its trigger has not come."""
    capture = rig.read_capture()
    if capture is None:
        return CaptureAnswer(complete=False)
    return CaptureAnswer(
        complete=True,
        trigger_tick=capture.trigger_tick,
        sample_time_s=capture.sample_time_s,
        columns=capture.columns,
    )


def _estop(rig: ServedRig, who: Principal, services: ServicesDep) -> RigAnswer:
    with services.audit.record(who, "rig.estop", f"rigs/{rig.id}"):
        rig.estop()
    rig.tell("rig.estop", f"{who.name} pressed e-stop", token_id=who.token_id)
    return RigAnswer.model_validate(rig.view())


def _refuse_strangers(rig: ServedRig, who: Principal) -> None:
    lease = rig.lease.view()
    if lease is not None and lease.token_id != who.token_id:
        raise LeaseError(f"{lease.holder} holds this rig", "wait until the lease ends, or take it over")
