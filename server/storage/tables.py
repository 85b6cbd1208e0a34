"""The tables. Samples, reports and uploads are files; a row holds their paths relative to the data folder."""

from datetime import datetime
from typing import Any

import sqlalchemy as sa
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column, relationship

from server.storage.types import UtcDateTime, utc_now

Json = dict[str, Any]  # JSON values


class Base(DeclarativeBase):
    """Base of all tables; named constraints, so that migrations can change them."""

    metadata = sa.MetaData(
        naming_convention={
            "ix": "ix_%(table_name)s_%(column_0_N_name)s",
            "uq": "uq_%(table_name)s_%(column_0_N_name)s",
            "fk": "fk_%(table_name)s_%(column_0_N_name)s",
            "pk": "pk_%(table_name)s",
        }
    )
    type_annotation_map = {datetime: UtcDateTime(), Json: sa.JSON(), list[str]: sa.JSON()}


class TokenRow(Base):
    """An access token: the first characters as its id, the SHA-256 of the whole, and what it may do."""

    __tablename__ = "tokens"
    id: Mapped[str] = mapped_column(sa.String(16), primary_key=True)
    name: Mapped[str] = mapped_column(sa.String(120))
    sha256: Mapped[str] = mapped_column(sa.String(64), unique=True)
    scopes: Mapped[list[str]]
    created_at: Mapped[datetime] = mapped_column(default=utc_now)
    expires_at: Mapped[datetime | None]
    revoked_at: Mapped[datetime | None]


class AuditRow(Base):
    """Somebody moved or changed something, or was not allowed to."""

    __tablename__ = "audit"
    id: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    at: Mapped[datetime] = mapped_column(default=utc_now, index=True)
    token_id: Mapped[str] = mapped_column(sa.String(16))
    token_name: Mapped[str] = mapped_column(sa.String(120))
    action: Mapped[str] = mapped_column(sa.String(80), index=True)
    resource: Mapped[str] = mapped_column(sa.String(200), index=True)
    outcome: Mapped[str] = mapped_column(sa.String(400))
    details: Mapped[Json] = mapped_column(default=dict)


class RigEventRow(Base):
    """Something happened to a rig, or to work on it; `tick` is the controller's where it has one."""

    __tablename__ = "rig_events"
    id: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    at: Mapped[datetime] = mapped_column(default=utc_now)
    rig_id: Mapped[str] = mapped_column(sa.String(80), index=True)
    kind: Mapped[str] = mapped_column(sa.String(60), index=True)
    tick: Mapped[int | None] = mapped_column(sa.BigInteger)
    text: Mapped[str] = mapped_column(sa.Text, default="")
    data: Mapped[Json] = mapped_column(default=dict)


class LeaseRow(Base):
    """Who held a rig from when to when, and how it ended; live leases are in memory only."""

    __tablename__ = "leases"
    id: Mapped[str] = mapped_column(sa.String(40), primary_key=True)
    rig_id: Mapped[str] = mapped_column(sa.String(80), index=True)
    token_id: Mapped[str] = mapped_column(sa.String(16))
    holder: Mapped[str] = mapped_column(sa.String(120))
    acquired_at: Mapped[datetime] = mapped_column(default=utc_now)
    ended_at: Mapped[datetime | None]
    ended_by: Mapped[str | None] = mapped_column(sa.String(40))


class SessionRow(Base):
    """One identification session."""

    __tablename__ = "sessions"
    id: Mapped[str] = mapped_column(sa.String(40), primary_key=True)
    rig_id: Mapped[str] = mapped_column(sa.String(80), index=True)
    name: Mapped[str] = mapped_column(sa.String(120))
    state: Mapped[str] = mapped_column(sa.String(20), index=True)
    reason: Mapped[str] = mapped_column(sa.Text, default="")
    spec: Mapped[Json] = mapped_column(default=dict)
    figures: Mapped[Json] = mapped_column(default=dict)
    folder: Mapped[str | None] = mapped_column(sa.String(400))
    recording_id: Mapped[str | None] = mapped_column(sa.String(40))
    created_by: Mapped[str] = mapped_column(sa.String(120), default="")
    created_at: Mapped[datetime] = mapped_column(default=utc_now, index=True)
    started_at: Mapped[datetime | None]
    ended_at: Mapped[datetime | None]


class CampaignRow(Base):
    """One submitted campaign; `position` orders the queue of its rig."""

    __tablename__ = "campaigns"
    id: Mapped[str] = mapped_column(sa.String(40), primary_key=True)
    rig_id: Mapped[str] = mapped_column(sa.String(80), index=True)
    name: Mapped[str] = mapped_column(sa.String(120))
    state: Mapped[str] = mapped_column(sa.String(20), index=True)
    reason: Mapped[str] = mapped_column(sa.Text, default="")
    position: Mapped[int] = mapped_column(default=0)
    document: Mapped[Json] = mapped_column(default=dict)
    folder: Mapped[str | None] = mapped_column(sa.String(400))
    created_by: Mapped[str] = mapped_column(sa.String(120), default="")
    created_at: Mapped[datetime] = mapped_column(default=utc_now, index=True)
    started_at: Mapped[datetime | None]
    ended_at: Mapped[datetime | None]
    items: Mapped[list["CampaignItemRow"]] = relationship(
        back_populates="campaign", order_by="CampaignItemRow.position", cascade="all, delete-orphan"
    )


class CampaignItemRow(Base):
    """One step of a campaign."""

    __tablename__ = "campaign_items"
    id: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    campaign_id: Mapped[str] = mapped_column(sa.ForeignKey("campaigns.id", ondelete="CASCADE"), index=True)
    position: Mapped[int]
    kind: Mapped[str] = mapped_column(sa.String(20))
    title: Mapped[str] = mapped_column(sa.String(300))
    state: Mapped[str] = mapped_column(sa.String(20))
    reason: Mapped[str] = mapped_column(sa.Text, default="")
    figures: Mapped[Json] = mapped_column(default=dict)
    recording_id: Mapped[str | None] = mapped_column(sa.String(40))
    started_at: Mapped[datetime | None]
    ended_at: Mapped[datetime | None]
    campaign: Mapped[CampaignRow] = relationship(back_populates="items")


class RecordingRow(Base):
    """One recording; its samples are the file at `path`."""

    __tablename__ = "recordings"
    id: Mapped[str] = mapped_column(sa.String(40), primary_key=True)
    name: Mapped[str] = mapped_column(sa.String(200), index=True)
    path: Mapped[str] = mapped_column(sa.String(400), unique=True)
    origin: Mapped[str] = mapped_column(sa.String(20))
    rig_id: Mapped[str | None] = mapped_column(sa.String(80), index=True)
    session_id: Mapped[str | None] = mapped_column(sa.String(40), index=True)
    campaign_id: Mapped[str | None] = mapped_column(sa.String(40), index=True)
    samples: Mapped[int] = mapped_column(default=0)
    samples_lost: Mapped[int] = mapped_column(default=0)
    duration_s: Mapped[float] = mapped_column(default=0.0)
    size_octets: Mapped[int] = mapped_column(sa.BigInteger, default=0)
    details: Mapped[Json] = mapped_column(default=dict)
    created_by: Mapped[str] = mapped_column(sa.String(120), default="")
    created_at: Mapped[datetime] = mapped_column(default=utc_now, index=True)
    deleted_at: Mapped[datetime | None]
    purge_at: Mapped[datetime | None]


class ModelRow(Base):
    """One version of a joint's model."""

    __tablename__ = "models"
    id: Mapped[str] = mapped_column(sa.String(40), primary_key=True)
    name: Mapped[str] = mapped_column(sa.String(120), index=True)
    version: Mapped[int]
    document: Mapped[Json] = mapped_column(default=dict)
    note: Mapped[str] = mapped_column(sa.Text, default="")
    created_by: Mapped[str] = mapped_column(sa.String(120), default="")
    created_at: Mapped[datetime] = mapped_column(default=utc_now, index=True)
    lineage: Mapped[list["LineageRow"]] = relationship(cascade="all, delete-orphan")
    __table_args__ = (sa.UniqueConstraint("name", "version"),)


class LineageRow(Base):
    """What a model version came from: a recording, an analysis, or the version before it."""

    __tablename__ = "model_lineage"
    id: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    model_id: Mapped[str] = mapped_column(sa.ForeignKey("models.id", ondelete="CASCADE"), index=True)
    kind: Mapped[str] = mapped_column(sa.String(20))
    source_id: Mapped[str] = mapped_column(sa.String(40), index=True)


class DiscrepancyRow(Base):
    """One run of the discrepancy workflow."""

    __tablename__ = "discrepancies"
    id: Mapped[str] = mapped_column(sa.String(40), primary_key=True)
    state: Mapped[str] = mapped_column(sa.String(20), index=True)
    reason: Mapped[str] = mapped_column(sa.Text, default="")
    request: Mapped[Json] = mapped_column(default=dict)
    progress: Mapped[Json] = mapped_column(default=dict)
    result: Mapped[Json] = mapped_column(default=dict)
    folder: Mapped[str | None] = mapped_column(sa.String(400))
    model_id: Mapped[str | None] = mapped_column(sa.String(40), index=True)
    created_by: Mapped[str] = mapped_column(sa.String(120), default="")
    created_at: Mapped[datetime] = mapped_column(default=utc_now, index=True)
    started_at: Mapped[datetime | None]
    ended_at: Mapped[datetime | None]
