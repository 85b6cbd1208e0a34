"""Forgets events and lines of the audit log that are older than the settings say, a little at a time.

Numbers of what stays never change, so whoever continues behind a number still can.
"""

import logging
import threading
from datetime import datetime, timedelta

import sqlalchemy as sa

from server.storage.database import Database
from server.storage.tables import AuditRow, RigEventRow
from server.storage.types import utc_now

_LOG = logging.getLogger(__name__)
_EVERY_S = 3600.0
_BATCH = 1000
_PAUSE_S = 0.05


class Retention:
    """A thread that looks once an hour.

    Args:
        database: where events and the log are kept.
        keep_events_days: age at which events are forgotten.
        keep_audit_days: the same of the audit log.
    """

    def __init__(self, database: Database, keep_events_days: float, keep_audit_days: float) -> None:
        self._database = database
        self._keep: tuple[tuple[type[RigEventRow] | type[AuditRow], float], ...] = (
            (RigEventRow, keep_events_days),
            (AuditRow, keep_audit_days),
        )
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="jointscope-retention", daemon=True)

    def start(self) -> None:
        """Begin to look."""
        self._thread.start()

    def close(self) -> None:
        """End after the batch under way."""
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join()

    def forget_old(self, now: datetime) -> int:
        """Delete what is too old and return how many rows that were."""
        return sum(self._forget(table, now - timedelta(days=days)) for table, days in self._keep)

    def _forget(self, table: type[RigEventRow] | type[AuditRow], before: datetime) -> int:
        """Delete from the oldest on, in short transactions, so that other writers never wait for long."""
        deleted = 0
        while not self._closing.is_set():
            with self._database.read() as session:
                oldest = session.execute(sa.select(table.id, table.at).order_by(table.id).limit(_BATCH)).all()
            old = [row.id for row in oldest if row.at < before]
            if old:
                with self._database.write() as session:
                    session.execute(sa.delete(table).where(table.id.in_(old)))
                deleted += len(old)
            if len(old) < _BATCH:
                break
            self._closing.wait(_PAUSE_S)
        return deleted

    def _run(self) -> None:
        while True:
            try:
                self.forget_old(utc_now())
            except sa.exc.SQLAlchemyError:
                _LOG.exception("old events and audit lines could not be forgotten")
            if self._closing.wait(_EVERY_S):
                return
