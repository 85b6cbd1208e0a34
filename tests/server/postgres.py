"""A private PostgreSQL server for tests, where its programs are installed: own folder, own socket, no network."""

import contextlib
import os
import pwd
import shutil
import subprocess
import tempfile
import uuid
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import psycopg

# Where Debian keeps them, newest first; elsewhere they are on the path.
_DEBIAN = "/usr/lib/postgresql"
# A test's data need not survive the machine; `-k` is the folder of the socket.
_OPTIONS = "-c fsync=off -c full_page_writes=off -c listen_addresses='' -c shared_buffers=16MB"
REASON = "no PostgreSQL server program (initdb) is installed here"


@dataclass(frozen=True, slots=True)
class Cluster:
    """A running server.

    Attributes:
        folder: of its socket.
        owner: name of its superuser.
    """

    folder: Path
    owner: str

    def url(self, database: str) -> str:
        """Return the URL of one of its databases."""
        return f"postgresql://{self.owner}@/{database}?host={self.folder}"

    def create(self) -> str:
        """Make an empty database and return its URL."""
        name = f"test_{uuid.uuid4().hex}"
        with psycopg.connect(self.url("postgres"), autocommit=True) as connection:
            connection.execute(f"CREATE DATABASE {name}".encode())
        return self.url(name)


def find_programs() -> Path | None:
    """Return the folder of `initdb` and `pg_ctl`, None where PostgreSQL is not installed."""
    for folder in sorted(Path(_DEBIAN).glob("*/bin"), reverse=True):
        if (folder / "initdb").exists():
            return folder
    found = shutil.which("initdb")
    return None if found is None else Path(found).parent


@contextlib.contextmanager
def private_cluster(programs: Path) -> Iterator[Cluster]:
    """Run a server until the block ends. It refuses to run as root: then `postgres` or `nobody` runs it."""
    user = _unprivileged()
    # A socket's path may have 107 characters, and pytest's folders are long.
    with tempfile.TemporaryDirectory(prefix="jspg-") as name:
        folder = Path(name)
        if user is not None:
            shutil.chown(folder, user)
        owner = user or pwd.getpwuid(os.getuid()).pw_name
        data = folder / "data"

        def call(program: str, *arguments: str) -> None:
            command = [str(programs / program), *arguments]
            done = subprocess.run(command, user=user, cwd=folder, stdout=subprocess.DEVNULL, check=False)
            assert done.returncode == 0, f"{program} ended with {done.returncode}; see its message above"

        call("initdb", "-D", str(data), "--no-sync", "-A", "trust", "-E", "UTF8", "--locale", "C")
        log, options = str(folder / "log"), f"{_OPTIONS} -k {folder}"
        call("pg_ctl", "start", "-w", "-D", str(data), "-l", log, "-o", options)
        try:
            yield Cluster(folder, owner)
        finally:
            call("pg_ctl", "stop", "-w", "-m", "immediate", "-D", str(data))


def _unprivileged() -> str | None:
    if os.getuid() != 0:
        return None
    known = {each.pw_name for each in pwd.getpwall()}
    return "postgres" if "postgres" in known else "nobody"
