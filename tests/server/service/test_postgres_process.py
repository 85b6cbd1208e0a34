"""The service process on PostgreSQL; skipped where no server program is installed (docs/database.md)."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import psycopg
import pytest
import sqlalchemy as sa

from tests.server.postgres import Cluster
from tests.server.service.conftest import Service
from tests.server.service.killing import kill_and_restart, submit

Start = Callable[..., Service]


@pytest.mark.slow
def test_on_postgresql_a_killed_campaign_is_in_order_after_a_restart(
    start_service: Start, tmp_path: Path, postgres: Cluster
) -> None:
    data, database = tmp_path / "data", postgres.create()
    service = start_service(data=data, database=database, speed="1")
    service.connect()
    client = service.client()
    campaign = submit(client)
    events = ("/api/v1/events", {"kind": "campaign.running"})
    service.wait_for(
        lambda: client.get(events[0], params=events[1]).json()["items"], "the campaign's beginning"
    )

    def again() -> Service:
        started = start_service(data=data, database=database, speed="1", token=service.admin_token)
        started.connect()
        return started

    second, aftermath = kill_and_restart(service, campaign, again)
    assert aftermath.faults == ()
    assert aftermath.state == ("running", "interrupted")
    kept = second.client().get(events[0], params=events[1]).json()["items"]
    assert [each["data"]["id"] for each in kept] == [campaign]
    assert not (data / "jointscope.db").exists()


def test_while_the_database_is_away_requests_are_answered_by_503_and_afterwards_as_before(
    start_service: Start, tmp_path: Path, postgres: Cluster
) -> None:
    database = postgres.create()
    client = start_service(data=tmp_path / "data", database=database).client()
    assert client.get("/api/v1/models").status_code == 200
    name = sa.make_url(database).database
    with psycopg.connect(postgres.url("postgres"), autocommit=True) as server:
        server.execute(f"ALTER DATABASE {name} ALLOW_CONNECTIONS false".encode())
        server.execute("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = %s", (name,))
        refused = client.get("/api/v1/models")
        server.execute(f"ALTER DATABASE {name} ALLOW_CONNECTIONS true".encode())
    assert refused.status_code == 503
    assert refused.json()["type"] == "/problems/storage"
    assert client.get("/api/v1/models").status_code == 200


def test_a_token_is_made_in_the_database_that_the_command_names(tmp_path: Path, postgres: Cluster) -> None:
    command = [sys.executable, "-m", "server", "token"]
    options = ["--data", str(tmp_path / "data"), "--database", postgres.create()]
    subprocess.run([*command, "create", "--name", "bench \u03c9", *options], check=True, capture_output=True)
    listed = subprocess.run([*command, "list", *options], check=True, capture_output=True, text=True)
    assert "bench \u03c9" in listed.stdout


def test_a_server_that_does_not_answer_is_one_clear_line(tmp_path: Path) -> None:
    url = "postgresql://me:hidden@127.0.0.1:1/jointscope"
    command = [sys.executable, "-m", "server", "serve", "--data", str(tmp_path / "data"), "--database", url]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert done.returncode == 2
    assert "me:***@127.0.0.1:1/jointscope cannot be used" in done.stderr
    assert "hidden" not in done.stdout + done.stderr
    assert "Traceback" not in done.stderr
