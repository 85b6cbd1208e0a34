"""Identification sessions."""

import json
from typing import Annotated, Any

from fastapi import APIRouter, Path

from server.api.dependencies import ReadDep, RunDep, ServicesDep
from server.api.job_filter import WantedDep
from server.api.schemas.jobs import SessionAnswer, SessionBody, SessionPage
from server.services.container import Services
from server.services.jobs.machine import Happening
from server.services.tokens import Principal

router = APIRouter(prefix="/sessions", tags=["sessions"])
SessionId = Annotated[str, Path(max_length=40, description="The session's id.")]


@router.post("", status_code=201)
def create_session(body: SessionBody, who: RunDep, services: ServicesDep) -> SessionAnswer:
    """Check a session against the rig's limits and keep it; nothing moves before it is started."""
    with services.audit.record(who, "session.create", "sessions", name=body.name, rig=body.rig) as details:
        made = services.sessions.create(body.to_spec(), who)
        details["id"] = made.id
    return SessionAnswer.model_validate(made)


@router.get("")
def list_sessions(services: ServicesDep, who: ReadDep, wanted: WantedDep) -> SessionPage:
    """List sessions, newest first."""
    found = services.sessions.page(wanted)
    following = found[-1].id if len(found) == wanted.limit else None
    return SessionPage(items=[SessionAnswer.model_validate(each) for each in found], next_before=following)


@router.get("/{session_id}")
def read_session(session_id: SessionId, services: ServicesDep, who: ReadDep) -> SessionAnswer:
    """Tell where a session stands; while it runs, with live estimates."""
    return SessionAnswer.model_validate(services.sessions.get(session_id))


@router.get("/{session_id}/identification")
def read_identification(
    session_id: SessionId, services: ServicesDep, who: ReadDep
) -> dict[str, Any]:  # JSON values
    """Return the session's identification.json, as `jointscope identify` writes it."""
    path = services.sessions.identification(session_id)
    document: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))  # JSON values
    return document


@router.post("/{session_id}/start", status_code=202)
def start_session(session_id: SessionId, who: RunDep, services: ServicesDep) -> SessionAnswer:
    """Begin: the session takes the rig's lease as its own, records, and identifies."""
    with services.audit.record(who, "session.start", f"sessions/{session_id}"):
        return SessionAnswer.model_validate(services.sessions.start(session_id, who))


@router.post("/{session_id}/pause", status_code=202)
def pause_session(session_id: SessionId, who: RunDep, services: ServicesDep) -> SessionAnswer:
    """Bring the drive to rest and wait; the record under way is put aside and made anew on resume."""
    return _ask(session_id, Happening.PAUSE, who, services)


@router.post("/{session_id}/resume", status_code=202)
def resume_session(session_id: SessionId, who: RunDep, services: ServicesDep) -> SessionAnswer:
    """Go on after a pause."""
    return _ask(session_id, Happening.RESUME, who, services)


@router.post("/{session_id}/stop", status_code=202)
def stop_session(session_id: SessionId, who: RunDep, services: ServicesDep) -> SessionAnswer:
    """End the record now, in order, and identify on what was recorded."""
    return _ask(session_id, Happening.STOP, who, services)


@router.post("/{session_id}/abort", status_code=202)
def abort_session(session_id: SessionId, who: RunDep, services: ServicesDep) -> SessionAnswer:
    """End the session now, in order; the recording is kept, nothing is identified."""
    return _ask(session_id, Happening.ABORT, who, services)


def _ask(session_id: str, happening: Happening, who: Principal, services: Services) -> SessionAnswer:
    with services.audit.record(who, f"session.{happening}", f"sessions/{session_id}"):
        return SessionAnswer.model_validate(services.sessions.ask(session_id, happening))
