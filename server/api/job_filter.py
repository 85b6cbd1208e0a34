"""The query that lists of jobs take."""

from typing import Annotated

from fastapi import Depends, Query

from server.api.schemas.jobs import JOB_ID_PATTERN
from server.services.jobs.ledger import JobFilter
from server.services.jobs.machine import JobState

_Text = Annotated[str | None, Query(max_length=120)]


def read_filter(
    rig: _Text = None,
    state: JobState | None = None,
    name: _Text = None,
    before: Annotated[
        str | None, Query(pattern=JOB_ID_PATTERN, description="Continue after this id: `next_before`.")
    ] = None,
    limit: Annotated[int, Query(ge=1, le=500)] = 50,
) -> JobFilter:
    """Return which jobs are asked for."""
    return JobFilter(rig_id=rig, state=state, name=name, before=before, limit=limit)


WantedDep = Annotated[JobFilter, Depends(read_filter)]
