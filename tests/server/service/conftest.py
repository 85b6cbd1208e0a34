"""The service as its users have it: a process of its own with an emulated controller, spoken to over HTTP.

`start_service` starts one for a test; `service` is one that the tests of a file share. `Service.client(scope)` gives an
httpx client whose token has that scope; `Service.hold(...)` holds a rig's lease for the length of a `with` block.
"""

import contextlib
import hashlib
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx
import psycopg
import pytest
import sqlalchemy as sa

from server.storage.database import database_url

CONFIG = Path(__file__).resolve().parents[3] / "config"
RIG = "emulated"
LEASE = "Jointscope-Lease"
# URL of a PostgreSQL server: every service of these tests then has a database of its own there (docs/database.md).
ON_POSTGRES = "JOINTSCOPE_TEST_POSTGRES"
_READY = re.compile(r"Jointscope is at (\S+)")
_TOKEN = re.compile(r"shown this once: (\S+)")
_PATIENCE_S = 60.0


@dataclass
class Service:
    """A running service process."""

    process: subprocess.Popen[str]
    data: Path
    database: str
    url: str
    admin_token: str
    clients: list[httpx.Client] = field(default_factory=list)
    tokens: dict[str, str] = field(default_factory=dict)

    def client(self, scope: str | None = "admin") -> httpx.Client:
        """Return a client with a token of this scope; None has no token."""
        headers = {} if scope is None else {"Authorization": f"Bearer {self.token(scope)}"}
        client = httpx.Client(base_url=self.url, headers=headers, timeout=_PATIENCE_S)
        self.clients.append(client)
        return client

    def token(self, scope: str) -> str:
        """Return a token with this scope, made once."""
        if scope == "admin":
            return self.admin_token
        if scope not in self.tokens:
            answer = self.client().post("/api/v1/tokens", json={"name": f"test {scope}", "scopes": [scope]})
            self.tokens[scope] = answer.json()["secret"]
        return self.tokens[scope]

    @contextlib.contextmanager
    def hold(self, client: httpx.Client, rig: str = RIG, ttl_s: float = 60.0) -> Iterator[dict[str, str]]:
        """Hold a rig's lease; gives the headers that show it."""
        answer = client.post(f"/api/v1/rigs/{rig}/lease", json={"ttl_s": ttl_s})
        assert answer.status_code == 201, answer.text
        headers = {LEASE: answer.json()["id"]}
        try:
            yield headers
        finally:
            client.delete(f"/api/v1/rigs/{rig}/lease", headers=headers)

    def wait_for(self, look: Callable[[], Any], what: str) -> Any:  # Any: whatever the test looks for
        """Look again and again until something true is found."""
        deadline_s = time.monotonic() + _PATIENCE_S
        while time.monotonic() < deadline_s:
            found = look()
            if found:
                return found
            time.sleep(0.02)
        raise AssertionError(f"{what} did not come within {_PATIENCE_S:g} s")

    def connect(self, rig: str = RIG) -> None:
        """Connect a rig and wait until it is."""
        client = self.client()
        client.post(f"/api/v1/rigs/{rig}/connect")
        self.wait_for(
            lambda: client.get(f"/api/v1/rigs/{rig}").json()["drive"] is not None,
            f"the drive's state of {rig}",
        )

    def stop(self, number: int = signal.SIGTERM) -> int:
        """End the process and return its exit code."""
        for client in self.clients:
            client.close()
        self.clients.clear()
        if self.process.poll() is None:
            self.process.send_signal(number)
        code = self.process.wait(_PATIENCE_S)
        if self.process.stdout is not None:
            self.process.stdout.close()
        return code


def _database_of(data: Path) -> str:
    """Return the database of a data folder: on the server that `ON_POSTGRES` names, made if need be, else its file."""
    server = os.environ.get(ON_POSTGRES)
    if not server:
        return database_url(data)
    name = f"test_{hashlib.sha256(str(data.resolve()).encode()).hexdigest()[:40]}"
    with psycopg.connect(server, autocommit=True) as connection:
        if not connection.execute("SELECT FROM pg_database WHERE datname = %s", (name,)).fetchall():
            connection.execute(f"CREATE DATABASE {name}".encode())
    return sa.make_url(server).set(database=name).render_as_string(hide_password=False)


def launch(
    data: Path, *options: str, speed: str = "max", token: str = "", database: str | None = None
) -> Service:
    """Start a service on a free port and wait until it says where it is."""
    database = database or _database_of(data)
    command = [sys.executable, "-m", "server", "serve", "--port", "0", "--data", str(data), "--speed", speed]
    command += [
        "--rigs",
        str(CONFIG / "rigs"),
        "--emulate",
        str(CONFIG / "scenarios" / "nominal.yaml"),
        *options,
    ]
    if not database.startswith("sqlite"):
        command += ["--database", database]
    environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment
    )
    assert process.stdout is not None
    lines: list[str] = []
    url = ""
    for line in process.stdout:
        lines.append(line)
        if match := _READY.search(line):
            url = match[1]
        if match := _TOKEN.search(line):
            token = match[1]
        if url and ("token" in line):
            return Service(process=process, data=data, database=database, url=url, admin_token=token)
    raise AssertionError(f"the service ended with {process.wait()}: {''.join(lines)}")


@pytest.fixture
def start_service(tmp_path: Path) -> Iterator[Callable[..., Service]]:
    """Return a function that starts services; all are ended after the test."""
    services: list[Service] = []

    def start(*options: str, data: Path = tmp_path / "data", **more: str) -> Service:
        services.append(launch(data, *options, **more))
        return services[-1]

    yield start
    for service in services:
        service.stop()


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """Give a service with the emulated rig connected, shared by a file's tests."""
    started = launch(tmp_path_factory.mktemp("service") / "data")
    started.connect()
    yield started
    started.stop()


@pytest.fixture
def rested(service: Service) -> Service:
    """Give the shared service with its rig held by nobody and its faults cleared."""
    client = service.client()
    taken = client.post(f"/api/v1/rigs/{RIG}/lease", json={"take_over": True})
    headers = {LEASE: taken.json()["id"]}
    client.post(f"/api/v1/rigs/{RIG}/clear-fault", headers=headers)
    client.delete(f"/api/v1/rigs/{RIG}/lease", headers=headers)
    return service
