"""Recordings as JSON."""

from datetime import datetime
from typing import Any

from pydantic import Field

from server.api.schemas.base import Answer


class RecordingAnswer(Answer):
    """One recording; its samples and files have addresses of their own."""

    id: str = Field(examples=["0b6f3f0e-5f0c-4a58-9c9e-0f1f6a1c2d3e"])
    name: str = Field(examples=["train"])
    origin: str = Field(examples=["session"], description="session, campaign, upload or recovered.")
    rig_id: str | None
    session_id: str | None
    campaign_id: str | None
    samples: int = Field(examples=[2505997])
    samples_lost: int = Field(description="Known to be missing.")
    duration_s: float
    sample_time_s: float | None
    size_octets: int
    columns: dict[str, str] = Field(
        description="Unit of each column.", examples=[{"time_s": "s", "current_A": "A"}]
    )
    unreadable: str = Field(description="Why its file cannot be read; empty when it can.")
    details: dict[str, Any] = Field(description="Excitation, how it ended, source, software.")  # JSON values
    created_by: str
    created_at: datetime
    deleted_at: datetime | None
    purge_at: datetime | None = Field(description="When the files of a deleted recording go.")
    purged: bool = Field(description="Its files are gone.")


class RecordingList(Answer):
    """Newest first; `cursor` continues, null at the end."""

    items: list[RecordingAnswer]
    cursor: str | None


class SampleAnswer(Answer):
    """Samples as JSON; as Arrow, the same columns and, in the schema's metadata, the same facts."""

    rows: int
    of_rows: int = Field(description="Samples of the span, before it was thinned out.")
    sample_time_s: float
    units: dict[str, str]
    columns: dict[str, list[float | bool | None]] = Field(
        examples=[{"time_s": [0.0, 0.0004], "current_A": [0.0, 0.1], "gap": [False, False]}]
    )
