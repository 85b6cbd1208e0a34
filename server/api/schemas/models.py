"""Model versions and discrepancy analyses as JSON."""

from datetime import datetime
from typing import Annotated, Any

from pydantic import Field

from server.api.schemas.base import Answer, Request
from server.services.models import SourceKind

Id = Annotated[str, Field(min_length=1, max_length=40)]


class SourceAnswer(Answer):
    """One thing that a model version came from."""

    kind: SourceKind
    id: str


class ModelAnswer(Answer):
    """One version of a model."""

    id: str
    name: str = Field(examples=["joint1"])
    version: int = Field(examples=[2])
    note: str
    effects: list[str] = Field(examples=[["coulomb_friction"]])
    document: dict[str, Any] = Field(description="The model file's content.")  # JSON values
    lineage: list[SourceAnswer]
    created_by: str
    created_at: datetime


class ModelList(Answer):
    """Newest first; `next_offset` continues, null at the end."""

    items: list[ModelAnswer]
    next_offset: int | None


class DiscrepancyBody(Request):
    """What to ask: what does this model lack, judged by these recordings?"""

    model: Id = Field(description="Id of a model version.")
    train: Annotated[list[Id], Field(min_length=1, max_length=50)] = Field(
        description="Recordings that may be fitted; two with the same input show the noise."
    )
    test: Annotated[list[Id], Field(min_length=1, max_length=50)] = Field(
        description="Recordings that only score."
    )


class DiscrepancyRequestAnswer(Answer):
    """What was asked."""

    model: str
    train: list[str]
    test: list[str]


class DiscrepancyAnswer(Answer):
    """One analysis."""

    id: str
    state: str = Field(
        examples=["running"], description="queued, running, done, failed, cancelled or interrupted."
    )
    reason: str = Field(description="Why it did not end well.")
    request: DiscrepancyRequestAnswer
    progress: dict[str, Any] = Field(  # JSON values
        description="While it runs.",
        examples=[{"text": "120 fits of candidate effects done", "fits": 120, "elapsed_s": 15.2}],
    )
    result: dict[str, Any] = Field(  # JSON values
        description="The heart of gap.json, once done.",
        examples=[{"verdict": "named", "effects": ["coulomb_friction"]}],
    )
    model_id: str | None = Field(description="The extended model, once done.")
    created_by: str
    created_at: datetime
    started_at: datetime | None
    ended_at: datetime | None


class DiscrepancyList(Answer):
    """Newest first; `next_offset` continues, null at the end."""

    items: list[DiscrepancyAnswer]
    next_offset: int | None
