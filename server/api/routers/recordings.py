"""Recordings: list, samples, upload, download, deletion with a period of grace."""

import re
from datetime import datetime
from typing import Annotated

from fastapi import APIRouter, Header, Path, Query, Request
from fastapi.responses import FileResponse, Response
from pydantic import BeforeValidator
from starlette.background import BackgroundTask
from starlette.concurrency import run_in_threadpool

from server.api.bodies import OCTETS_TYPE, document_body, pour
from server.api.dependencies import AdminDep, ReadDep, RunDep, ServicesDep
from server.api.schemas.recordings import RecordingAnswer, RecordingList, SampleAnswer
from server.services.recordings.files import DownloadFormat, Upload
from server.services.recordings.listing import RecordingFilter
from server.services.recordings.samples import SampleRequest, as_arrow, as_json, read_samples

ARROW_TYPE = "application/vnd.apache.arrow.stream"
MAX_TIME_S = 1e9
router = APIRouter(prefix="/recordings", tags=["recordings"])
RecordingId = Annotated[str, Path(description="The recording's id.", max_length=40)]
Name = Annotated[str, Query(max_length=80)]
ColumnName = Annotated[str, Query(max_length=80, pattern=r"^[A-Za-z][A-Za-z0-9_]*$", examples=["current_A"])]
Seconds = Annotated[float, Query(ge=-MAX_TIME_S, le=MAX_TIME_S)]
# Year to minute; pydantic judges the rest.
_DATE_AND_TIME = re.compile(r"[0-9]{4}-[0-9]{2}-[0-9]{2}[Tt _][0-9]{2}:[0-9]{2}")


def _refuse_numbers(value: object) -> object:
    """Refuse what is no date and time: pydantic would take 0.5 for half a second after 1970."""
    if isinstance(value, str) and not _DATE_AND_TIME.match(value):
        raise ValueError("a date and time is needed, such as 2026-01-31T12:00:00Z")
    return value


Moment = Annotated[datetime, BeforeValidator(_refuse_numbers)]
_BINARY = {"schema": {"type": "string", "format": "binary"}}


@router.get("")
def list_recordings(  # noqa: PLR0913  # one parameter for each filter
    services: ServicesDep,
    who: ReadDep,
    rig: Annotated[Name | None, Query(description="Recorded by this rig.")] = None,
    session: Annotated[Name | None, Query(description="Made by this session.")] = None,
    campaign: Annotated[Name | None, Query(description="Made by this campaign.")] = None,
    origin: Annotated[Name | None, Query(description="session, campaign, upload or recovered.")] = None,
    since: Annotated[Moment | None, Query(description="Listed then or later; without a zone, UTC.")] = None,
    until: Annotated[Moment | None, Query(description="Listed before.")] = None,
    column: Annotated[ColumnName | None, Query(description="Has this column.")] = None,
    text: Annotated[Name | None, Query(description="Part of the name, whatever the case.")] = None,
    deleted: Annotated[bool, Query(description="List the deleted ones instead.")] = False,
    cursor: Annotated[
        str | None,
        Query(max_length=200, pattern="^[A-Za-z0-9_-]+=*$", description="`cursor` of the page before."),
    ] = None,
    limit: Annotated[int, Query(ge=1, le=500)] = 100,
) -> RecordingList:
    """List recordings, newest first."""
    wanted = RecordingFilter(
        rig_id=rig,
        session_id=session,
        campaign_id=campaign,
        origin=origin,
        since=since,
        until=until,
        column=column,
        text=text,
        deleted=deleted,
    )
    return RecordingList.model_validate(services.recordings.page(wanted, cursor=cursor, limit=limit))


@router.post(
    "",
    status_code=201,
    openapi_extra=document_body(OCTETS_TYPE, schema={"type": "string", "format": "binary"}),
)
async def upload_recording(  # noqa: PLR0913  # one parameter for each thing that can be said of a file
    request: Request,
    services: ServicesDep,
    who: RunDep,
    file: Annotated[
        str,
        Query(
            min_length=1,
            max_length=200,
            examples=["measured.csv.gz"],
            description="The file's name; its ending says what it is: .csv, .csv.gz, .parquet, .mat, .h5, .hdf5.",
        ),
    ],
    name: Annotated[str | None, Query(min_length=1, max_length=200, description="Of the recording.")] = None,
    mapping: Annotated[
        list[str] | None,
        Query(
            alias="map",
            max_length=50,
            examples=[["current_A=i[mA]"]],
            description="NEW=OLD, NEW=OLD*FACTOR, NEW=OLD[UNIT].",
        ),
    ] = None,
    leave_out: Annotated[list[str] | None, Query(max_length=200, description="Columns not to take.")] = None,
    start_s: Annotated[Seconds | None, Query(description="Take from here on; needs stop_s.")] = None,
    stop_s: Annotated[Seconds | None, Query(description="Take up to here; needs start_s.")] = None,
) -> RecordingAnswer:
    """Upload a measured file: the body is its content. Columns whose names end in one of our units are taken."""
    upload = Upload(
        file_name=file,
        name=name,
        mappings=tuple(mapping or ()),
        leave_out=tuple(leave_out or ()),
        span_s=None
        if start_s is None and stop_s is None
        else (start_s or 0.0, MAX_TIME_S if stop_s is None else stop_s),
        created_by=who.name,
    )
    incoming = await run_in_threadpool(services.files.begin, upload)
    try:
        await pour(request, incoming.write)

        def take() -> RecordingAnswer:
            with services.audit.record(who, "recording.upload", "recordings", file=file) as details:
                taken = services.files.take(incoming, upload)
                details["id"] = taken.id
            return RecordingAnswer.model_validate(taken)

        return await run_in_threadpool(take)
    finally:
        await run_in_threadpool(incoming.discard)


@router.get("/{recording_id}")
def read_recording(recording_id: RecordingId, services: ServicesDep, who: ReadDep) -> RecordingAnswer:
    """Tell what is known of a recording, deleted or not."""
    return RecordingAnswer.model_validate(services.recordings.get(recording_id))


@router.get(
    "/{recording_id}/samples",
    response_class=Response,
    responses={200: {"model": SampleAnswer, "description": "Samples.", "content": {ARROW_TYPE: _BINARY}}},
)
def read_recording_samples(  # noqa: PLR0913  # one parameter for each choice
    recording_id: RecordingId,
    services: ServicesDep,
    who: ReadDep,
    column: Annotated[
        list[str] | None, Query(max_length=50, description="Only these; repeat it for more.")
    ] = None,
    start_s: Annotated[Seconds | None, Query(description="From this time on.")] = None,
    stop_s: Annotated[Seconds | None, Query(description="Up to this time, which is left out.")] = None,
    every: Annotated[int, Query(ge=1, le=10**9, description="Every so manieth sample, unfiltered.")] = 1,
    points: Annotated[
        int | None,
        Query(ge=1, le=100_000, description="Instead: NAME_min and NAME_max over so many pieces, to draw."),
    ] = None,
    accept: Annotated[str, Header(description=f"application/json or {ARROW_TYPE}.")] = "application/json",
) -> Response:
    """Read samples, as JSON or as an Arrow IPC stream, by Accept. `gap` says where samples are missing just before."""
    wanted = SampleRequest(
        columns=tuple(column or ()), start_s=start_s, stop_s=stop_s, every=every, points=points
    )
    samples = read_samples(services.recordings.path(recording_id), wanted)
    if ARROW_TYPE in accept:
        return Response(as_arrow(samples), media_type=ARROW_TYPE)
    return Response(as_json(samples), media_type="application/json")


@router.get(
    "/{recording_id}/file",
    response_class=FileResponse,
    responses={200: {"content": {OCTETS_TYPE: _BINARY}, "description": "The file."}},
)
def download_recording(
    recording_id: RecordingId,
    services: ServicesDep,
    who: ReadDep,
    wanted: Annotated[
        DownloadFormat,
        Query(
            alias="format",
            description="`stored` is the file as it is kept, raw counts included; the others are in SI.",
        ),
    ] = DownloadFormat.PARQUET,
) -> FileResponse:
    """Download a recording in one of the export formats."""
    download = services.files.export(recording_id, wanted)
    return FileResponse(
        download.path,
        filename=download.name,
        media_type=OCTETS_TYPE,
        background=BackgroundTask(download.discard),
    )


@router.delete("/{recording_id}")
def delete_recording(recording_id: RecordingId, services: ServicesDep, who: RunDep) -> RecordingAnswer:
    """Delete a recording; until `purge_at` it can be taken back."""
    with services.audit.record(who, "recording.delete", f"recordings/{recording_id}"):
        return RecordingAnswer.model_validate(services.recordings.delete(recording_id))


@router.post("/{recording_id}/undelete")
def undelete_recording(recording_id: RecordingId, services: ServicesDep, who: RunDep) -> RecordingAnswer:
    """Take a deletion back."""
    with services.audit.record(who, "recording.undelete", f"recordings/{recording_id}"):
        return RecordingAnswer.model_validate(services.recordings.undelete(recording_id))


@router.post("/{recording_id}/purge")
def purge_recording(recording_id: RecordingId, services: ServicesDep, who: AdminDep) -> RecordingAnswer:
    """Remove the files of a deleted recording now, for good."""
    with services.audit.record(who, "recording.purge", f"recordings/{recording_id}"):
        return RecordingAnswer.model_validate(services.recordings.purge(recording_id))
