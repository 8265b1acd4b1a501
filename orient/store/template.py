"""A new project as bytes: an empty one is kept in memory, and the runs of a small one are stored there.

SQLite reads all tables, guards and views anew for each file that it opens, which takes longer than storing the lists of
a photo. The empty project is built from schema.json; that this is what the migrations build is tested.
"""

import errno
import os
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from threading import local

from sqlalchemy import Connection

from orient.store import ledger
from orient.store.connection import connect_in_memory, driver_of, let_run
from orient.store.error_map import translated
from orient.store.format import Format
from orient.store.guards import own_names
from orient.store.runs import NewRun
from orient.store.watch import Watch

ORDER = ("table", "index", "view", "trigger")
_KEPT = local()


def write_project(path: Path, form: Format, new: Sequence[NewRun] = ()) -> None:
    """Fill an existing empty file with a project of these runs; the caller syncs it."""
    with translated(path, Watch("write")), path.open("r+b") as file, empty_project(form) as connection:
        _write(file.fileno(), _with_runs(connection, new, form))


def _write(descriptor: int, content: bytes) -> None:
    try:
        while content:
            content = content[os.write(descriptor, content) :]
    except OSError as error:
        raise _as_sqlite_says(error) from error


def _as_sqlite_says(error: OSError) -> sqlite3.OperationalError:
    """A full disk and a broken one are told in the words of all other writing."""
    told = sqlite3.OperationalError(error.strerror)
    is_full = error.errno in (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)
    told.sqlite_errorname = "SQLITE_FULL" if is_full else "SQLITE_IOERR"
    return told


@contextmanager
def empty_project(form: Format) -> Iterator[Connection]:
    """The one in memory that this thread keeps, or a new one; after an error it is kept no longer."""
    form_of_kept, kept = vars(_KEPT).pop("project", (None, None))
    connection = kept if form_of_kept is form else _built(form)
    yield connection
    _KEPT.project = form, connection


def _with_runs(connection: Connection, new: Sequence[NewRun], form: Format) -> bytes:
    """The bytes of the project with these runs, which are undone in memory."""
    with connection.begin() as transaction:
        ledger.append_all(connection, new, form)
        content = driver_of(connection).serialize()
        transaction.rollback()
    return content


def _built(form: Format) -> Connection:
    def build(driver: sqlite3.Connection) -> None:
        driver.execute("BEGIN")
        for kind, _, _, sql in sorted(form.objects, key=lambda item: ORDER.index(item[0])):
            if kind == "trigger" and driver.total_changes == 0:
                driver.execute("INSERT INTO alembic_version VALUES (?)", (form.head,))
            if sql is not None:
                driver.execute(sql)
        driver.execute(f"PRAGMA application_id = {form.application_id}")
        driver.execute(f"PRAGMA user_version = {form.version}")
        driver.execute("COMMIT")

    watch = Watch()
    connection = connect_in_memory(build, watch)
    let_run(connection, watch, own_names(form))
    watch.phase = "write"
    return connection
