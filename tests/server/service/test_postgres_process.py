"""The service process on PostgreSQL; skipped where no server program is installed (docs/database.md)."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

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
