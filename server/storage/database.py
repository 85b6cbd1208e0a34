"""The database: SQLite in WAL mode below the data folder, or PostgreSQL by URL; one writer, short transactions.

Theory of operation. Everybody reads at any time. Writers of this process queue at a lock, so that no two of them
meet in SQLite and find it busy; each takes the write lock at its beginning (BEGIN IMMEDIATE), because a transaction
that begins by reading and then wants to write cannot wait for another process, only fail. Another process (`jointscope
token create` beside a running service) waits up to `BUSY_TIMEOUT_S`. Samples never come here: they are files.
"""

import contextlib
import threading
from collections.abc import Iterator
from pathlib import Path

import sqlalchemy as sa
from alembic import command
from alembic.config import Config
from sqlalchemy.orm import Session

BUSY_TIMEOUT_S = 10.0
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
        with self._engine.begin() as connection:
            config.attributes["connection"] = connection
            command.upgrade(config, "head")

    def close(self) -> None:
        """Give all connections back."""
        self._engine.dispose()


def database_url(data_dir: Path) -> str:
    """Return the URL of the SQLite file below the data folder."""
    return f"sqlite:///{data_dir / FILE_NAME}"


def open_database(url: str) -> Database:
    """Open the database at `url` and bring its tables to the newest version."""
    sqlite = url.startswith("sqlite")
    options: dict[str, object] = {"connect_args": {"timeout": BUSY_TIMEOUT_S}} if sqlite else {}
    engine = sa.create_engine(url, **options)
    if sqlite:
        sa.event.listen(engine, "connect", _prepare_sqlite)
        sa.event.listen(engine, "begin", _begin_sqlite)
    database = Database(engine)
    try:
        database.migrate()
    except BaseException:
        database.close()
        raise
    return database


def _prepare_sqlite(connection: "sa.engine.interfaces.DBAPIConnection", record: object) -> None:
    """Set up a connection; transactions are begun by `_begin_sqlite`, not by the driver."""
    connection.isolation_level = None
    cursor = connection.cursor()
    for pragma in ("journal_mode=WAL", "synchronous=NORMAL", "foreign_keys=ON"):
        cursor.execute(f"PRAGMA {pragma}")
    cursor.close()


def _begin_sqlite(connection: sa.Connection) -> None:
    writes = connection.get_execution_options().get("writes", False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")
