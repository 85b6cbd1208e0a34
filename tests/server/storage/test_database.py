"""Migrations, transactions and times of the database."""

import threading
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import psycopg
import pytest
import sqlalchemy as sa
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext

from server.errors import InputError
from server.storage.database import Database, database_url, open_database
from server.storage.tables import AuditRow, Base, CampaignItemRow, CampaignRow, RigEventRow
from tests.server.postgres import Cluster


@pytest.fixture(params=["sqlite", "postgresql"])
def url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Give the URL of an empty database of either kind."""
    if request.param == "sqlite":
        return database_url(tmp_path)
    cluster: Cluster = request.getfixturevalue("postgres")
    return cluster.create()


@pytest.fixture
def database(url: str) -> Iterator[Database]:
    opened = open_database(url)
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


def test_opening_twice_changes_nothing(database: Database, url: str) -> None:
    with database.write() as session:
        session.add(event("a"))
    open_database(url).close()
    assert count(database) == 1


def test_the_file_is_in_wal_mode(tmp_path: Path) -> None:
    database = open_database(database_url(tmp_path))
    with database.read() as session:
        assert session.scalar(sa.text("PRAGMA journal_mode")) == "wal"
    database.close()


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


def test_a_reader_sees_one_state_while_others_write(database: Database) -> None:
    with database.read() as session:
        before = session.scalar(sa.select(sa.func.count(RigEventRow.id)))
        with database.write() as other:
            other.add(event("a"))
        assert session.scalar(sa.select(sa.func.count(RigEventRow.id))) == before
    assert count(database) == 1


def test_writers_of_two_connections_wait_for_each_other(database: Database, url: str) -> None:
    other = open_database(url)

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


def test_a_text_may_hold_every_character(database: Database) -> None:
    with database.write() as session:
        session.add(RigEventRow(rig_id="\0 \u03c9 \U0001f600", kind="test", text="a\0b", data={"x": "a\0b"}))
    with database.read() as session:
        row = session.scalars(
            sa.select(RigEventRow).where(RigEventRow.rig_id == "\0 \u03c9 \U0001f600")
        ).one()
    assert row.text in ("a\0b", "a\ufffdb")
    assert row.data == {"x": "a\0b"}


def test_one_service_has_a_database_of_postgresql_for_itself(
    postgres: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.storage.engines.BUSY_TIMEOUT_S", 0.2)
    url = postgres.create()
    first, second = open_database(url), open_database(url)
    first.claim()
    with pytest.raises(InputError, match="another service uses this database"):
        second.claim()
    first.close()
    second.claim()
    second.close()


def test_a_server_that_was_restarted_is_found_again(postgres: Cluster) -> None:
    database = open_database(postgres.create())
    assert count(database) == 0
    with psycopg.connect(postgres.url("postgres"), autocommit=True) as connection:
        connection.execute(
            "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE pid <> pg_backend_pid()"
        )
    assert count(database) == 0
    database.close()


@pytest.mark.parametrize(
    ("url", "complaint"),
    [
        ("nonsense", "is no database URL"),
        ("mysql://somewhere/x", '"mysql" is not supported'),
        ("postgresql://me:hidden@127.0.0.1:1/x", r"me:\*\*\*@127.0.0.1:1/x cannot be used"),
    ],
)
def test_a_wrong_url_is_refused_with_its_reason(url: str, complaint: str) -> None:
    with pytest.raises(InputError, match=complaint):
        open_database(url)
