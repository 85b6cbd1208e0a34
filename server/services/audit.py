"""The audit log: who moved or changed what, when, and what came of it; refused attempts included."""

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from typing import Any

import sqlalchemy as sa

from server.services.tokens import Principal
from server.storage.database import Database
from server.storage.tables import AuditRow

_MAX_OUTCOME = 400


@dataclass(frozen=True, slots=True, kw_only=True)
class AuditEntry:
    """One line of the log."""

    id: int
    at: datetime
    token_id: str
    token_name: str
    action: str
    resource: str
    outcome: str
    details: dict[str, Any]  # JSON values


class AuditLog:
    """Writes and reads the log.

    Args:
        database: where it is kept.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    @contextlib.contextmanager
    def record(
        self, who: Principal, action: str, resource: str, **details: Any
    ) -> Iterator[dict[str, Any]]:  # JSON values
        """Log an action with what comes of it; an error is logged as the outcome and goes on.

        Gives the details, to which the action may add what it found out.
        """
        outcome = "done"
        try:
            yield details
        except BaseException as error:
            outcome = f"{type(error).__name__}: {error}"[:_MAX_OUTCOME]
            raise
        finally:
            self.write(who, action, resource, outcome, details)

    def write(
        self, who: Principal, action: str, resource: str, outcome: str, details: dict[str, Any]
    ) -> None:  # JSON values
        """Write one line."""
        with self._database.write() as session:
            session.add(
                AuditRow(
                    token_id=who.token_id,
                    token_name=who.name,
                    action=action,
                    resource=resource,
                    outcome=outcome,
                    details=details,
                )
            )

    def page(
        self, *, resource: str | None = None, before: int | None = None, limit: int = 100
    ) -> list[AuditEntry]:
        """Return the newest lines first."""
        query = sa.select(AuditRow).order_by(AuditRow.id.desc()).limit(limit)
        if resource is not None:
            query = query.where(AuditRow.resource == resource)
        if before is not None:
            query = query.where(AuditRow.id < before)
        with self._database.read() as session:
            return [_entry(row) for row in session.scalars(query)]


def _entry(row: AuditRow) -> AuditEntry:
    return AuditEntry(
        id=row.id,
        at=row.at,
        token_id=row.token_id,
        token_name=row.token_name,
        action=row.action,
        resource=row.resource,
        outcome=row.outcome,
        details=row.details,
    )
