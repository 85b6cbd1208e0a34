"""Events as JSON."""

from datetime import datetime
from typing import Any

from pydantic import Field

from server.api.schemas.base import Answer


class EventAnswer(Answer):
    """One thing that happened."""

    id: int = Field(description="Number in order; continue after it.")
    at: datetime
    rig_id: str
    kind: str = Field(examples=["drive.fault"])
    tick: int | None = Field(description="Controller tick, 32 bits; null for what the host noticed.")
    text: str
    data: dict[str, Any]  # JSON values


class EventPage(Answer):
    """Events in order; `next_after` continues, null at the end."""

    items: list[EventAnswer]
    next_after: int | None
