"""Engines of the two databases, set up so that the rest of the program need not know which one it has.

Both give the same: a reader sees one state of the database for as long as it reads and writes nothing, writers of all
processes queue at one lock and give up after `BUSY_TIMEOUT_S`, and a text that one of them takes the other takes too.
SQLite has the lock in the file (BEGIN IMMEDIATE); PostgreSQL gets an advisory one, held until the transaction ends.
"""

from typing import Any

import sqlalchemy as sa

from server.errors import InputError, InputLocation

BUSY_TIMEOUT_S = 10.0
# Any two numbers do, as long as nothing else in the same database uses them: "JSCP" in ASCII, and one more.
WRITE_LOCK, SERVICE_LOCK = 0x4A534350, 0x4A534351
_POOL, _POOL_MORE = 5, 30


def make_engine(url: str) -> sa.Engine:
    """Return the engine for a URL; nothing is connected yet.

    Raises:
        InputError: no URL of SQLite or PostgreSQL, or the driver for PostgreSQL is not installed.
    """
    try:
        parsed = sa.make_url(url)
    except sa.exc.ArgumentError as error:
        raise _refused("is no database URL") from error
    if parsed.drivername == "sqlite":
        return _sqlite_engine(parsed)
    if parsed.drivername in ("postgresql", "postgres", "postgresql+psycopg"):
        return _postgres_engine(parsed.set(drivername="postgresql+psycopg"))
    raise _refused(f'"{parsed.drivername}" is not supported')


def is_postgres(engine: sa.Engine) -> bool:
    """Tell which of the two it is."""
    return engine.dialect.name == "postgresql"


def unreachable(engine: sa.Engine, error: sa.exc.OperationalError) -> InputError:
    """Say that the database did not answer, without its password."""
    where = engine.url.render_as_string(hide_password=True)
    reason = " ".join(str(error.orig).split())
    return InputError(f"{where} cannot be used: {reason}", InputLocation(field="--database"))


def _refused(reason: str) -> InputError:
    example = "postgresql://jointscope@db.example/jointscope"
    return InputError(f"{reason}; give one like {example}", InputLocation(field="--database"))


def _sqlite_engine(url: sa.URL) -> sa.Engine:
    engine = sa.create_engine(url, connect_args={"timeout": BUSY_TIMEOUT_S})
    sa.event.listen(engine, "connect", _prepare_sqlite)
    sa.event.listen(engine, "begin", _begin_sqlite)
    return engine


def _prepare_sqlite(connection: "sa.engine.interfaces.DBAPIConnection", record: object) -> None:
    """Set up a connection; transactions are begun by `_begin_sqlite`, not by the driver."""
    connection.isolation_level = None
    cursor = connection.cursor()
    for pragma in ("journal_mode=WAL", "synchronous=NORMAL", "foreign_keys=ON"):
        cursor.execute(f"PRAGMA {pragma}")
    cursor.close()


def _begin_sqlite(connection: sa.Connection) -> None:
    connection.exec_driver_sql("BEGIN IMMEDIATE" if _writes(connection) else "BEGIN")


def _postgres_engine(url: sa.URL) -> sa.Engine:
    options = f"-c lock_timeout={round(1e3 * BUSY_TIMEOUT_S)} -c timezone=UTC"
    try:
        engine = sa.create_engine(
            url,
            connect_args={"connect_timeout": round(BUSY_TIMEOUT_S), "options": options},
            pool_pre_ping=True,  # a server that was restarted meanwhile costs one more connection, not an error
            pool_size=_POOL,
            max_overflow=_POOL_MORE,
        )
    except ModuleNotFoundError as error:
        raise _refused("needs psycopg (pip install 'jointscope[postgres]')") from error
    sa.event.listen(engine, "connect", _prepare_postgres)
    sa.event.listen(engine, "begin", _begin_postgres)
    return engine


def _prepare_postgres(connection: Any, record: object) -> None:  # Any: psycopg need not be installed
    """Let texts hold the character NUL, which PostgreSQL does not know, as U+FFFD; SQLite stores it as it is."""
    from psycopg.types.string import StrDumperUnknown, StrDumperVarchar

    for base in (StrDumperVarchar, StrDumperUnknown):
        connection.adapters.register_dumper(str, _without_nul(base))


def _without_nul(base: Any) -> Any:  # Any: a class of psycopg's
    def dump(self: Any, obj: str) -> Any:  # Any: what the class of psycopg's takes and returns
        return base.dump(self, obj.replace("\0", "\ufffd"))

    return type(base.__name__, (base,), {"dump": dump})


def _begin_postgres(connection: sa.Connection) -> None:
    if _writes(connection):
        connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({WRITE_LOCK})")
    else:
        connection.exec_driver_sql("SET TRANSACTION ISOLATION LEVEL REPEATABLE READ, READ ONLY")


def _writes(connection: sa.Connection) -> bool:
    return bool(connection.get_execution_options().get("writes", False))
