"""From a path to a connection that has passed the gate: preflight, recovery, fingerprint, checks."""

import os
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import Connection, Engine, RootTransaction

from orient.store.connection import Mode, let_run, open_engine, scalar
from orient.store.error_map import translated
from orient.store.errors import ReadOnly, Replaced
from orient.store.fingerprint import check_fingerprint, check_pages
from orient.store.format import Format
from orient.store.guards import own_names
from orient.store.preflight import OPEN_FILES, Preflight, identity
from orient.store.watch import Watch

CHECKED_BYTES = 50 * 10**6
"""Smaller files are checked page by page at every opening."""
SCHEMA_DEADLINE_S = 3.0
CHECK_DEADLINE_S = 60.0


@dataclass(slots=True)
class Gated:
    """A connection that has passed the gate, and the schema version that it was checked at."""

    path: Path
    engine: Engine
    connection: Connection
    watch: Watch
    schema_version: int
    file: tuple[int, int]

    def begin(self, immediate: bool = False) -> RootTransaction:
        """A transaction in which the views and guards that run are those that were compared."""
        self.connection.execution_options(immediate=immediate)
        transaction = self.connection.begin()
        try:
            self._require_same_schema()
        except BaseException:
            transaction.rollback()  # who comes next would take it for one that was looked at
            raise
        return transaction

    def _require_same_schema(self) -> None:
        if schema_version_of(self.connection) != self.schema_version:
            message = f"{self.path}: another program altered the schema meanwhile."
            raise Replaced(message, "Nothing was stored. Run it again.")

    def close(self) -> None:
        OPEN_FILES[self.file] -= 1
        self.connection.close()
        self.engine.dispose()


def pass_gate(look: Preflight, mode: Mode, form: Format, with_checks: bool = True) -> Gated:
    """Connect, compare the schema, check the pages of a small file, and let its views and guards run."""
    watch = Watch()
    engine = open_engine(look.path, mode, watch)
    file = identity(look.path)
    with translated(look.path, watch):
        connection = engine.connect()
        try:
            with connection.begin():
                schema_version = _inspect(connection, look, form, watch, with_checks)
                let_run(connection, watch, own_names(form))
        except BaseException:
            connection.close()
            engine.dispose()
            raise
    watch.phase = mode
    OPEN_FILES[file] += 1
    return Gated(look.path, engine, connection, watch, schema_version, file)


def _inspect(connection: Connection, look: Preflight, form: Format, watch: Watch, with_checks: bool) -> int:
    with watch.within(SCHEMA_DEADLINE_S):
        schema_version = schema_version_of(connection)
        check_fingerprint(connection, form, look.path)
    if with_checks and look.size < CHECKED_BYTES:
        with watch.within(CHECK_DEADLINE_S):
            check_pages(connection, look.path)
    return schema_version


def schema_version_of(connection: Connection) -> int:
    return int(scalar(connection, "PRAGMA main.schema_version"))


def recover(look: Preflight) -> None:
    """Let SQLite undo what an interrupted command left in a hot journal; needs a writable folder."""
    watch = Watch()
    engine = open_engine(look.path, "write", watch)
    try:
        with translated(look.path, watch), engine.connect() as connection:
            connection.exec_driver_sql("SELECT count(*) FROM main.sqlite_schema").scalar_one()
    finally:
        engine.dispose()


def tidy(gated: Gated, form: Format) -> None:
    """Remove a stale journal: only a real write does it, so the format number is written over itself."""
    with gated.begin(immediate=True):
        gated.connection.exec_driver_sql(f"PRAGMA main.user_version = {form.version}")


def require_writable(path: Path) -> None:
    """Say before any computing that the file or its folder cannot be written."""
    if not (os.access(path, os.W_OK) and os.access(path.parent, os.W_OK)):
        message = f"{path} cannot be written (read-only file or folder). Reading commands work."
        raise ReadOnly(message, "Copy it to write.")
