"""A list of campaigns costs the same number of queries however long it is."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import sqlalchemy as sa

from server.services.campaigns import CampaignService
from server.services.jobs.board import JobBoard
from server.services.jobs.ledger import JobFilter
from server.services.rigs.registry import RigRegistry
from server.services.tokens import TokenService
from server.storage.database import Database, database_url, open_database
from server.storage.tables import CampaignItemRow, CampaignRow


@contextmanager
def counted(database: Database) -> Iterator[list[str]]:
    """Keep all statements of a block."""
    seen: list[str] = []

    def note(connection: object, cursor: object, statement: str, *more: object) -> None:
        seen.append(statement)

    sa.event.listen(database.engine, "before_cursor_execute", note)
    try:
        yield seen
    finally:
        sa.event.remove(database.engine, "before_cursor_execute", note)


@pytest.fixture
def database(tmp_path: Path) -> Iterator[Database]:
    """A database with thirty campaigns of three steps each."""
    opened = open_database(database_url(tmp_path))
    with opened.write() as session:
        for number in range(30):
            items = [
                CampaignItemRow(position=k, kind="wait", title=f"step {k} of {number}", state="queued")
                for k in (2, 0, 1)
            ]
            session.add(
                CampaignRow(
                    id=f"{number:032x}",
                    rig_id="rig",
                    name=f"campaign-{number}",
                    state="done",
                    position=number,
                    document={},
                    folder="",
                    created_by="test",
                    items=items,
                )
            )
    yield opened
    opened.close()


@pytest.mark.parametrize("limit", [1, 30])
def test_the_steps_of_all_listed_campaigns_come_by_one_query(
    database: Database, tmp_path: Path, limit: int
) -> None:
    service = CampaignService(
        database, tmp_path, RigRegistry([]), JobBoard(), TokenService(database), models=None
    )
    with counted(database) as statements:
        found = service.page(JobFilter(limit=limit))
    assert len([each for each in statements if each.startswith("SELECT")]) == 2
    assert len(found) == limit
    for view in found:
        number = view.name.removeprefix("campaign-")
        assert [item.title for item in view.items] == [f"step {k} of {number}" for k in range(3)]
