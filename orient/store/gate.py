"""From a path to a connection that has passed the gate: preflight, recovery, fingerprint, checks, TEMP guards."""

import os
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import Connection, Engine

from orient.store.connection import Mode, open_engine
from orient.store.error_map import translated
from orient.store.errors import ReadOnly
from orient.store.fingerprint import check_fingerprint, check_pages
from orient.store.format import Format
from orient.store.guards import install_temporary
from orient.store.preflight import OPEN_FILES, Preflight, identity
from orient.store.watch import Watch

CHECKED_BYTES = 50 * 10**6
"""Smaller files are checked page by page at every opening."""
SCHEMA_DEADLINE_S = 3.0
CHECK_DEADLINE_S = 60.0


@dataclass(slots=True)
class Gated:
    """A connection that has passed the gate, and the schema version that it was checked at."""

    engine: Engine
    connection: Connection
    watch: Watch
    schema_version: int
    file: tuple[int, int]

    def close(self) -> None:
        OPEN_FILES[self.file] -= 1
        self.connection.close()
        self.engine.dispose()


def pass_gate(look: Preflight, mode: Mode, form: Format, with_checks: bool = True) -> Gated:
    """Connect, compare the schema, check the pages of a small file, install TEMP views and guards."""
    watch = Watch()
    engine = open_engine(look.path, mode, watch)
    file = identity(look.path)
    with translated(look.path, watch):
        connection = engine.connect()
        try:
            with connection.begin():
                schema_version = _inspect(connection, look, form, watch, with_checks)
                watch.names = install_temporary(connection, form, with_guards=mode == "write")
        except BaseException:
            connection.close()
            engine.dispose()
            raise
    watch.phase = mode
    OPEN_FILES[file] += 1
    return Gated(engine, connection, watch, schema_version, file)


def _inspect(connection: Connection, look: Preflight, form: Format, watch: Watch, with_checks: bool) -> int:
    with watch.within(SCHEMA_DEADLINE_S):
        schema_version = int(connection.exec_driver_sql("PRAGMA main.schema_version").scalar_one())
        check_fingerprint(connection, form, look.path)
    if with_checks and look.size < CHECKED_BYTES:
        with watch.within(CHECK_DEADLINE_S):
            check_pages(connection, look.path)
    return schema_version


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
    gated.connection.execution_options(immediate=True)
    with gated.connection.begin():
        gated.connection.exec_driver_sql(f"PRAGMA main.user_version = {form.version}")


def require_writable(path: Path) -> None:
    """Say before any computing that the file or its folder cannot be written."""
    if not (os.access(path, os.W_OK) and os.access(path.parent, os.W_OK)):
        message = f"{path} cannot be written (read-only file or folder). Reading commands work."
        raise ReadOnly(message, "Copy it to write.")
