"""Starting, restarting and ending the service."""

import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import sqlalchemy as sa

from server.storage.database import open_database
from server.storage.states import JobState
from server.storage.tables import SessionRow
from tests.server.service.conftest import RIG, Service

Start = Callable[..., Service]


def test_health_readiness_pages_and_document_need_no_token(service: Service) -> None:
    client = service.client(None)
    for path in ("/", "/docs", "/healthz", "/readyz", "/metrics", "/openapi.json"):
        assert client.get(path).status_code == 200, path
    assert 'href="docs"' in client.get("/").text
    assert f'jointscope_rig_connected{{rig="{RIG}"}} 1.0' in client.get("/metrics").text


def test_pages_fetch_nothing_from_elsewhere(service: Service) -> None:
    client = service.client(None)
    assert "http" not in client.get("/").text
    assert "src=" not in client.get("/docs").text


def test_a_second_service_on_the_same_data_folder_is_refused(service: Service) -> None:
    command = [sys.executable, "-m", "server", "serve", "--port", "0", "--data", str(service.data)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "another service uses this data folder" in done.stderr


def test_an_address_that_others_reach_needs_a_token_first(tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "server",
        "serve",
        "--host",
        "0.0.0.0",
        "--port",
        "0",
        "--data",
        str(tmp_path),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "there is no token yet; make one first by: jointscope token create" in done.stderr


def test_a_signal_ends_the_service_in_order_while_an_event_stream_is_open(start_service: Start) -> None:
    service = start_service()
    with service.client("read").stream("GET", "/api/v1/events/stream") as stream:
        assert next(stream.iter_lines()) == ": listening"
        service.process.send_signal(signal.SIGTERM)
        assert service.process.wait(30) == 0


def test_tokens_and_events_outlive_a_restart_and_what_was_running_is_interrupted(
    start_service: Start, tmp_path: Path
) -> None:
    data = tmp_path / "data"
    first = start_service(data=data)
    first.connect()
    first.stop(signal.SIGKILL)
    database = open_database(first.database)
    with database.write() as session:
        session.add(SessionRow(id="s1", rig_id=RIG, name="cut off", state=JobState.RUNNING.value))
    database.close()
    second = start_service(data=data, token=first.admin_token)
    rig = second.client().get(f"/api/v1/rigs/{RIG}").json()
    assert (rig["armed"], rig["lease"]) == (False, None)
    assert second.client().get("/api/v1/events", params={"kind": "rig.connection"}).json()["items"]
    second.stop()
    database = open_database(first.database)
    with database.read() as session:
        state, reason = session.execute(sa.select(SessionRow.state, SessionRow.reason)).one()
    database.close()
    assert state == "interrupted"
    assert "nothing was begun again" in reason
