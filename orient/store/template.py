"""An empty project as bytes: written as it is, instead of building sixty tables in every new file.

It is built from schema.json, in memory and once in a process. That this is what the migrations build is tested.
"""

import errno
import os
import sqlite3
from functools import cache
from pathlib import Path

from orient.store.error_map import translated
from orient.store.format import Format, current_format
from orient.store.watch import Watch

ORDER = ("table", "index", "view", "trigger")


def write_empty_project(path: Path, form: Format) -> None:
    """Fill an existing empty file with an empty project; the caller syncs it."""
    with translated(path, Watch()), path.open("r+b") as file:
        _write(file.fileno(), _empty_project() if form is current_format() else _built(form))


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


@cache
def _empty_project() -> bytes:
    return _built(current_format())


def _built(form: Format) -> bytes:
    connection = sqlite3.connect(":memory:", isolation_level=None)
    try:
        connection.execute("BEGIN")
        for kind, _, _, sql in sorted(form.objects, key=lambda item: ORDER.index(item[0])):
            if kind == "trigger" and connection.total_changes == 0:
                connection.execute("INSERT INTO alembic_version VALUES (?)", (form.head,))
            if sql is not None:
                connection.execute(sql)
        connection.execute(f"PRAGMA application_id = {form.application_id}")
        connection.execute(f"PRAGMA user_version = {form.version}")
        connection.execute("COMMIT")
        return connection.serialize()
    finally:
        connection.close()
