"""Everything that happens to rigs and work: stored with its tick, numbered, and told to whoever listens.

`publish` never waits, so that the port threads may call it: a thread of its own stores events in batches and tells
subscribers only what is stored, so that the number of an event is also the place to continue from.
"""

import logging
import queue
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

import sqlalchemy as sa

from server.services.rigs.fanout import Fanout
from server.storage.database import Database
from server.storage.tables import RigEventRow
from server.storage.types import utc_now

_LOG = logging.getLogger(__name__)
_MAX_WAITING = 10_000
_BATCH = 500


@dataclass(frozen=True, slots=True, kw_only=True)
class ServiceEvent:
    """One thing that happened.

    Attributes:
        id: number in order, 0 before it is stored.
        at: wall clock, UTC.
        rig_id: the rig concerned.
        kind: `rig.connection`, `drive.state`, `drive.fault`, `lease.taken_over`, ...; docs/api.md lists them.
        tick: controller tick, 32 bits, None for what the host noticed.
        text: one sentence for the operator.
        data: further JSON values.
    """

    rig_id: str
    kind: str
    text: str
    tick: int | None = None
    data: Mapping[str, Any] = field(default_factory=dict)  # JSON values
    at: datetime = field(default_factory=utc_now)
    id: int = 0


class EventLog:
    """Stores events and tells subscribers.

    Args:
        database: where they are stored.
    """

    def __init__(self, database: Database) -> None:
        self._database = database
        self._waiting: queue.Queue[ServiceEvent | None] = queue.Queue(_MAX_WAITING)
        self._thread = threading.Thread(target=self._run, name="jointscope-events", daemon=True)
        self.stored: Fanout[ServiceEvent] = Fanout()
        self.dropped = 0

    def start(self) -> None:
        """Begin to store."""
        self._thread.start()

    def close(self) -> None:
        """Store what waits, then end; subscribers are told."""
        if self._thread.is_alive():
            self._waiting.put(None)
            self._thread.join()
        self.stored.close()

    def publish(self, event: ServiceEvent) -> None:
        """Take an event; never waits. More than can be stored are dropped and counted."""
        try:
            self._waiting.put_nowait(event)
        except queue.Full:
            self.dropped += 1

    def page(
        self, *, rig_id: str | None = None, kind: str | None = None, after: int = 0, limit: int = 100
    ) -> list[ServiceEvent]:
        """Return stored events with numbers above `after`, oldest first."""
        query = sa.select(RigEventRow).where(RigEventRow.id > after).order_by(RigEventRow.id).limit(limit)
        if rig_id is not None:
            query = query.where(RigEventRow.rig_id == rig_id)
        if kind is not None:
            query = query.where(RigEventRow.kind == kind)
        with self._database.read() as session:
            return [_event(row) for row in session.scalars(query)]

    def newest_id(self) -> int:
        """Return the number of the newest stored event, 0 when there is none."""
        with self._database.read() as session:
            return session.scalar(sa.select(sa.func.max(RigEventRow.id))) or 0

    def _run(self) -> None:
        while (first := self._waiting.get()) is not None:
            batch, ending = [first], False
            while len(batch) < _BATCH and not self._waiting.empty():
                event = self._waiting.get()
                if event is None:
                    ending = True
                    break
                batch.append(event)
            self._store(batch)
            if ending:
                return

    def _store(self, batch: Sequence[ServiceEvent]) -> None:
        rows = [_row(event) for event in batch]
        try:
            with self._database.write() as session:
                session.add_all(rows)
        except sa.exc.SQLAlchemyError:  # a full disk must not end the thread: the next events may fit
            self.dropped += len(rows)
            _LOG.exception("%d events could not be stored", len(rows))
            return
        for row in rows:
            self.stored.publish(_event(row))


def _row(event: ServiceEvent) -> RigEventRow:
    return RigEventRow(
        at=event.at,
        rig_id=event.rig_id,
        kind=event.kind,
        tick=event.tick,
        text=event.text,
        data=dict(event.data),
    )


def _event(row: RigEventRow) -> ServiceEvent:
    return ServiceEvent(
        id=row.id,
        at=row.at,
        rig_id=row.rig_id,
        kind=row.kind,
        tick=row.tick,
        text=row.text,
        data=row.data,
    )
