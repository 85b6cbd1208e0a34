"""Old events and audit lines are forgotten, new ones kept."""

from datetime import timedelta
from pathlib import Path

import sqlalchemy as sa

from server.services.retention import Retention
from server.storage.database import database_url, open_database
from server.storage.tables import AuditRow, RigEventRow
from server.storage.types import utc_now


def test_what_is_older_than_the_limit_is_forgotten_and_numbers_stay(tmp_path: Path) -> None:
    database, now = open_database(database_url(tmp_path)), utc_now()
    ages_days = [40.0] * 2500 + [31.0, 29.0, 0.0]
    with database.write() as session:
        session.add_all(RigEventRow(rig_id="r", kind="k", at=now - timedelta(days=age)) for age in ages_days)
        session.add(
            AuditRow(
                token_id="t",
                token_name="n",
                action="a",
                resource="r",
                outcome="done",
                at=now - timedelta(days=40),
            )
        )
    assert Retention(database, keep_events_days=30.0, keep_audit_days=50.0).forget_old(now) == 2501
    with database.read() as session:
        assert session.scalars(sa.select(RigEventRow.id).order_by(RigEventRow.id)).all() == [2502, 2503]
        assert session.scalar(sa.select(sa.func.count(AuditRow.id))) == 1
    database.close()
