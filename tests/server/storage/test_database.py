"""Migrations, transactions and times of the database."""

import threading
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import pytest
import sqlalchemy as sa
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext

from server.storage.database import Database, database_url, open_database
from server.storage.tables import AuditRow, Base, CampaignItemRow, CampaignRow, RigEventRow


@pytest.fixture
def database(tmp_path: Path) -> Iterator[Database]:
    opened = open_database(database_url(tmp_path))
    yield opened
    opened.close()


def event(rig_id: str) -> RigEventRow:
    """Return a row to write."""
    return RigEventRow(rig_id=rig_id, kind="test", text="")


def count(database: Database) -> int:
    """Return how many events are stored."""
    with database.read() as session:
        return session.scalar(sa.select(sa.func.count(RigEventRow.id))) or 0


def test_migrations_make_the_tables_that_the_code_has(database: Database) -> None:
    with database.engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        assert compare_metadata(context, Base.metadata) == []


def test_opening_twice_changes_nothing(database: Database, tmp_path: Path) -> None:
    with database.write() as session:
        session.add(event("a"))
    open_database(database_url(tmp_path)).close()
    assert count(database) == 1


def test_the_file_is_in_wal_mode(database: Database) -> None:
    with database.read() as session:
        assert session.scalar(sa.text("PRAGMA journal_mode")) == "wal"


def test_an_error_takes_a_transaction_back(database: Database) -> None:
    with pytest.raises(ZeroDivisionError), database.write() as session:
        session.add(event("a"))
        session.flush()
        raise ZeroDivisionError
    assert count(database) == 0


def test_readers_see_the_state_before_a_writer_has_committed(database: Database) -> None:
    with database.write() as session:
        session.add(event("a"))
        session.flush()
        assert count(database) == 0
    assert count(database) == 1


def test_writers_of_two_connections_wait_for_each_other(database: Database, tmp_path: Path) -> None:
    other = open_database(database_url(tmp_path))

    def write(target: Database) -> None:
        for _ in range(50):
            with target.write() as session:
                session.add(event("a"))

    threads = [threading.Thread(target=write, args=(each,)) for each in (database, other, database, other)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    other.close()
    assert count(database) == 200


def test_a_moment_comes_back_in_utc(database: Database) -> None:
    moment = datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC)
    with database.write() as session:
        session.add(AuditRow(at=moment, token_id="", token_name="", action="", resource="", outcome=""))
    with database.read() as session:
        assert session.scalar(sa.select(AuditRow.at)) == moment


def test_a_campaigns_items_go_with_it(database: Database) -> None:
    campaign = CampaignRow(id="c", rig_id="r", name="n", state="queued")
    campaign.items = [CampaignItemRow(position=0, kind="wait", title="wait", state="queued")]
    with database.write() as session:
        session.add(campaign)
    with database.write() as session:
        session.delete(session.get_one(CampaignRow, "c"))
    with database.read() as session:
        assert session.scalar(sa.select(sa.func.count(CampaignItemRow.id))) == 0
