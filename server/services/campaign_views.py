"""Campaigns, their steps, queues and forecasts as everybody may see them."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any

from server.services.jobs.machine import Happening
from server.services.jobs.order import JobProgress
from server.services.jobs.planning import StepForecast
from server.storage.states import JobState
from server.storage.tables import CampaignItemRow

Json = dict[str, Any]  # JSON values


@dataclass(frozen=True, slots=True, kw_only=True)
class ItemView:
    """One step of a campaign."""

    position: int
    kind: str
    title: str
    state: JobState
    reason: str
    figures: Json
    recording_id: str | None
    started_at: datetime | None
    ended_at: datetime | None


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignView:
    """A campaign as everybody may see it."""

    id: str
    name: str
    rig_id: str
    state: JobState
    reason: str
    possible: tuple[Happening, ...]
    position: int
    duration_s: float
    items: tuple[ItemView, ...]
    progress: JobProgress | None
    created_by: str
    created_at: datetime
    started_at: datetime | None
    ended_at: datetime | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Forecast:
    """What a campaign would do."""

    name: str
    rig_id: str
    duration_s: float
    steps: tuple[StepForecast, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class QueueView:
    """The campaigns that wait for a rig, in order."""

    rig_id: str
    held: bool
    waiting: tuple[CampaignView, ...]


def item_view(item: CampaignItemRow) -> ItemView:
    """Return one step as it is shown."""
    return ItemView(
        position=item.position,
        kind=item.kind,
        title=item.title,
        state=JobState(item.state),
        reason=item.reason,
        figures=item.figures,
        recording_id=item.recording_id,
        started_at=item.started_at,
        ended_at=item.ended_at,
    )
