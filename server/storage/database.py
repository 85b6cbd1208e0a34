"""The database: SQLite in WAL mode below the data folder, or PostgreSQL by URL; one writer, short transactions.

Theory of operation. Everybody reads at any time. Writers of this process queue at a lock, so that no two of them
meet in SQLite and find it busy; each takes the database's own write lock at its beginning (`engines.py`), because a
transaction that begins by reading and then wants to write cannot wait for another process, only fail. Another process
(`jointscope token create` beside a running service) waits up to `BUSY_TIMEOUT_S`. Samples never come here: they are
files.
"""

import contextlib
import threading
from collections.abc import Iterator
from pathlib import Path

import sqlalchemy as sa
from alembic import command
from alembic.config import Config
from sqlalchemy.orm import Session

from server.errors import InputError, InputLocation
from server.storage.engines import SERVICE_LOCK, is_postgres, make_engine, unreachable

FILE_NAME = "jointscope.db"
MIGRATIONS = Path(__file__).parent / "migrations"


class Database:
    """Engine, write lock and migrations; make it by `open_database`.

    Args:
        engine: of SQLite or PostgreSQL.
    """

    def __init__(self, engine: sa.Engine) -> None:
        self._engine = engine
        self._writing = threading.Lock()
        self._claim: sa.PoolProxiedConnection | None = None

    @property
    def engine(self) -> sa.Engine:
        """For migrations and their tests."""
        return self._engine

    @contextlib.contextmanager
    def read(self) -> Iterator[Session]:
        """Give a session that sees one state of the database; nothing is written."""
        with Session(self._engine, expire_on_commit=False) as session:
            yield session

    @contextlib.contextmanager
    def write(self) -> Iterator[Session]:
        """Give a session whose changes are committed at the end; an error takes all of them back.

        Keep it short: other writers wait. Never call a rig or a file inside.
        """
        with self._writing, Session(self._engine, expire_on_commit=False) as session, session.begin():
            session.connection(execution_options={"writes": True})
            yield session

    def migrate(self) -> None:
        """Bring the tables to the newest version."""
        config = Config()
        config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
        with self._engine.execution_options(writes=True).begin() as connection:
            config.attributes["connection"] = connection
            command.upgrade(config, "head")

    def claim(self) -> None:
        """Keep other services off this database until it is closed; SQLite's is below a data folder that is locked.

        A service that was killed a moment ago may still have its claim: it is waited for, up to `BUSY_TIMEOUT_S`.

        Raises:
            InputError: another service uses it.
        """
        if not is_postgres(self._engine):
            return
        connection = self._engine.raw_connection()
        connection.detach()
        try:
            connection.cursor().execute(f"SELECT pg_advisory_lock({SERVICE_LOCK})")
            connection.commit()  # the lock is the connection's, not the transaction's
        except self._engine.dialect.loaded_dbapi.OperationalError as error:
            connection.close()
            raise InputError(
                "another service uses this database; end it, or give another database",
                InputLocation(field="--database"),
            ) from error
        self._claim = connection

    def close(self) -> None:
        """Give all connections back."""
        if self._claim is not None:
            self._claim.close()
            self._claim = None
        self._engine.dispose()


def database_url(data_dir: Path) -> str:
    """Return the URL of the SQLite file below the data folder."""
    return f"sqlite:///{data_dir / FILE_NAME}"


def open_database(url: str) -> Database:
    """Open the database at `url` and bring its tables to the newest version.

    Raises:
        InputError: no such database, or a server that does not answer.
    """
    database = Database(make_engine(url))
    try:
        database.migrate()
    except BaseException as error:
        database.close()
        if isinstance(error, sa.exc.OperationalError) and is_postgres(database.engine):
            raise unreachable(database.engine, error) from error
        raise
    return database
