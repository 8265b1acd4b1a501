"""The one way to connect to a project file (RELIABILITY.md 4.2 and 4.3). Order and values were all tried there."""

import os
import sqlite3
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.pool import NullPool

from orient.store.watch import Watch

Mode = Literal["read", "write"]

BUSY_TIMEOUT_S = 30.0
OPERATIONS_BETWEEN_LOOKS = 10_000
HEAP_LIMIT_BYTES = 512 * 2**20
SPILL = "PRAGMA cache_spill=1"
"""As soon as the cache is full; ON would leave the number of pages as it is."""
ALONE = ("PRAGMA journal_mode=MEMORY", "PRAGMA synchronous=OFF")

CACHE_SIZE = -2000
"""SQLite's own: 2000 kB."""
SPILL_PAGES = 65_535
"""256 MB of pages of 4096 bytes: a larger append goes through the file, so that its memory is bounded. Not 65 536: of
that SQLite keeps eight bits to tell on from off."""

LIMITS = {
    sqlite3.SQLITE_LIMIT_LENGTH: 64 * 2**20,
    sqlite3.SQLITE_LIMIT_SQL_LENGTH: 100_000,
    sqlite3.SQLITE_LIMIT_COLUMN: 200,
    sqlite3.SQLITE_LIMIT_EXPR_DEPTH: 100,
    sqlite3.SQLITE_LIMIT_COMPOUND_SELECT: 20,
    sqlite3.SQLITE_LIMIT_VDBE_OP: 250_000,
    sqlite3.SQLITE_LIMIT_FUNCTION_ARG: 16,
    sqlite3.SQLITE_LIMIT_ATTACHED: 0,
    sqlite3.SQLITE_LIMIT_LIKE_PATTERN_LENGTH: 200,
    sqlite3.SQLITE_LIMIT_TRIGGER_DEPTH: 10,
}

RUNNING = ("ENABLE_TRIGGER", "ENABLE_VIEW")

PRAGMAS = (
    "trusted_schema=OFF",
    "cell_size_check=ON",
    "mmap_size=0",
    "foreign_keys=ON",
    "recursive_triggers=ON",  # without it REPLACE slips past the delete guards
    "synchronous=EXTRA",  # without it a power cut can lose a commit that was reported
    f"cache_spill={SPILL_PAGES}",  # an append below it does not lock out the readers while it is being made
    f"hard_heap_limit={HEAP_LIMIT_BYTES}",
)
TEMPORARY = {"read": "temp_store=MEMORY", "write": "temp_store=DEFAULT"}
"""The journal of one statement: SQLite takes the 64 kB that one row needs in one piece, in memory a kilobyte at a time
and at every row. Set before the schema is read: SQLite forgets the schema when this changes."""


def open_engine(path: Path, mode: Mode, watch: Watch, immutable: bool = False) -> Engine:
    """An engine whose connections are hardened. The caller holds one connection and disposes the engine."""
    return _engine(lambda: hardened(path, mode, watch, immutable))


def connect_in_memory(build: Callable[[sqlite3.Connection], None], watch: Watch) -> Connection:
    """A connection to a database in memory, hardened as any other when `build` has made it."""

    def built() -> sqlite3.Connection:
        driver = sqlite3.connect(":memory:", isolation_level=None, check_same_thread=False)
        try:
            build(driver)
            _harden(driver, "write", watch)
        except BaseException:
            driver.close()
            raise
        return driver

    return _engine(built).connect()


def _engine(creator: Callable[[], sqlite3.Connection]) -> Engine:
    engine = create_engine("sqlite://", creator=creator, poolclass=NullPool, hide_parameters=True)
    event.listen(engine, "begin", _begin)
    return engine


def _begin(connection: Connection) -> None:
    immediate = connection.get_execution_options().get("immediate", False)
    execute(connection, "BEGIN IMMEDIATE" if immediate else "BEGIN DEFERRED")


def hardened(path: Path, mode: Mode, watch: Watch, immutable: bool = False) -> sqlite3.Connection:
    """A driver connection in autocommit, never creating a file, with limits, deadline, pragmas and authorizer."""
    connection = sqlite3.connect(
        uri_of(path, mode, immutable), uri=True, isolation_level=None, timeout=BUSY_TIMEOUT_S, check_same_thread=False
    )
    try:
        _harden(connection, mode, watch)
    except BaseException:
        connection.close()
        raise
    return connection


def uri_of(path: Path, mode: Mode, immutable: bool = False) -> str:
    """`file:` URI with %, ?, # escaped: a URL by string formatting would open another file."""
    tail = "mode=ro" if mode == "read" else "mode=rw"
    return Path(os.path.abspath(path)).as_uri() + "?" + tail + ("&immutable=1" if immutable else "")  # noqa: PTH100


def _harden(connection: sqlite3.Connection, mode: Mode, watch: Watch) -> None:
    for limit, value in LIMITS.items():
        connection.setlimit(limit, value)
    connection.set_progress_handler(watch.progress, OPERATIONS_BETWEEN_LOOKS)
    if sys.version_info >= (3, 12):
        _set_dbconfig(connection)
    for pragma in (*PRAGMAS, TEMPORARY[mode]):
        connection.execute(f"PRAGMA {pragma}").fetchall()
    connection.set_authorizer(watch.authorize)


def driver_of(connection: Connection) -> sqlite3.Connection:
    """The driver's connection, inside the transaction of `connection`: for many statements or rows."""
    driver = connection.connection.driver_connection
    assert isinstance(driver, sqlite3.Connection)
    return driver


def execute(connection: Connection, statement: str, parameters: Sequence[Any] = ()) -> sqlite3.Cursor:
    """One statement by the driver, inside the transaction of `connection`: without what SQLAlchemy does around it."""
    return driver_of(connection).execute(statement, parameters)


def scalar(connection: Connection, query: str, parameters: Sequence[Any] = ()) -> Any:
    """The first value of the first row; None without a row."""
    row = execute(connection, query, parameters).fetchone()
    return None if row is None else row[0]


def write_alone(connection: Connection) -> None:
    """Journal in memory, no syncs: only for a new file without a name, which is synced before it gets one."""
    for pragma in ALONE:
        driver_of(connection).execute(pragma).fetchall()


def let_spill(connection: Connection) -> None:
    """Let a large append go to the disk before its end: only into a file that nobody else knows yet."""
    driver_of(connection).execute(SPILL).fetchall()


@contextmanager
def room_to_append(connection: Connection) -> Iterator[None]:
    """A page cache as large as an append may grow before it spills: beyond its size every new page costs a search."""
    pages = scalar(connection, "PRAGMA main.cache_spill")
    execute(connection, f"PRAGMA main.cache_size={int(pages)}")
    yield  # after an error the connection is dropped
    execute(connection, f"PRAGMA main.cache_size={CACHE_SIZE}")


def compact_into(source: Path, target: Path) -> None:
    """Write the content of an examined file into an existing empty one, without free pages (VACUUM INTO).

    The only connection that may attach a file; it is opened after the gate and does nothing else.
    """
    connection = hardened(source, "read", Watch())
    try:
        connection.set_authorizer(None)
        connection.setlimit(sqlite3.SQLITE_LIMIT_ATTACHED, 1)
        connection.execute(SPILL).fetchall()
        connection.execute("VACUUM INTO ?", (os.fspath(target),))
    finally:
        connection.close()


def _set_dbconfig(connection: Any) -> None:
    """Triggers and views of the file are dead until the gate has compared them (Python 3.12 and later)."""
    connection.setconfig(sqlite3.SQLITE_DBCONFIG_DEFENSIVE, True)  # type: ignore[attr-defined]
    off = ("TRUSTED_SCHEMA", *RUNNING, "ENABLE_FTS3_TOKENIZER", "ENABLE_LOAD_EXTENSION", "DQS_DDL", "DQS_DML")
    for name in off:
        connection.setconfig(getattr(sqlite3, f"SQLITE_DBCONFIG_{name}"), False)


def let_run(connection: Connection, watch: Watch, names: frozenset[str]) -> None:
    """Let the compared views and triggers `names` run; on Python 3.11 the authorizer alone has held them back."""
    driver: Any = driver_of(connection)
    if sys.version_info >= (3, 12):
        for name in RUNNING:
            driver.setconfig(getattr(sqlite3, f"SQLITE_DBCONFIG_{name}"), True)
    watch.names = names
