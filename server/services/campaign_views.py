"""Campaigns, their steps, queues and forecasts as everybody may see them."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import groupby
from typing import Any

import sqlalchemy as sa

from server.services.jobs.books import shown_state
from server.services.jobs.ledger import JobRow
from server.services.jobs.machine import Happening, allowed
from server.services.jobs.order import JobProgress
from server.services.jobs.planning import StepForecast
from server.services.jobs.run import JobRun
from server.storage.database import Database
from server.storage.states import JobState
from server.storage.tables import CampaignItemRow, CampaignRow

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


def read_items(database: Database, campaign_ids: Sequence[str]) -> dict[str, tuple[ItemView, ...]]:
    """Return the steps of each of these campaigns, in order, by one query."""
    query = sa.select(CampaignItemRow).where(CampaignItemRow.campaign_id.in_(campaign_ids))
    with database.read() as session:
        rows = session.scalars(query.order_by(CampaignItemRow.campaign_id, CampaignItemRow.position))
        by_campaign = groupby(rows, key=lambda row: row.campaign_id)
        return {campaign_id: tuple(_item_view(row) for row in items) for campaign_id, items in by_campaign}


def campaign_view(row: JobRow, items: tuple[ItemView, ...], run: JobRun | None) -> CampaignView:
    """Return a campaign as it is shown.

    Args:
        row: what is stored of it.
        items: its steps.
        run: its job, None when it does not run.
    """
    if not isinstance(row, CampaignRow):
        raise TypeError("a row of another kind of job")
    state = shown_state(row)
    return CampaignView(
        id=row.id,
        name=row.name,
        rig_id=row.rig_id,
        state=state,
        reason=row.reason,
        possible=allowed(state),
        position=row.position,
        duration_s=row.document.get("duration_s", 0.0),
        items=items,
        progress=None if run is None or not run.alive else run.progress,
        created_by=row.created_by,
        created_at=row.created_at,
        started_at=row.started_at,
        ended_at=row.ended_at,
    )


def _item_view(item: CampaignItemRow) -> ItemView:
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
