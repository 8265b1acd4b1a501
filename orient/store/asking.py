"""SQL questions of the user: one reading statement, with a time limit."""

import re
import sqlite3
from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import Connection
from sqlalchemy.exc import DBAPIError

from orient.errors import OrientError, UsageError
from orient.store.error_map import error_name
from orient.store.watch import Watch

LEADING = re.compile(r"(?:\s+|--[^\n]*(?:\n|$)|/\*.*?\*/|\()*", re.DOTALL)
READING_WORDS = ("select", "with", "values", "explain")

Answer = tuple[tuple[str, ...], list[tuple[Any, ...]]]


def ask(
    connection: Connection,
    watch: Watch,
    sql: str,
    parameters: Sequence[Any] | Mapping[str, Any] = (),
    max_rows: int | None = None,
    timeout_s: float | None = 60.0,
) -> Answer:
    """Column names and rows. Only SELECT, WITH, VALUES and EXPLAIN; anything else is a `UsageError`."""
    _check_statement(sql)
    given = dict(parameters) if isinstance(parameters, Mapping) else tuple(parameters)
    connection.exec_driver_sql("PRAGMA query_only = ON")
    try:
        with watch.in_phase("query"), watch.within(timeout_s):
            cursor = connection.exec_driver_sql(sql, given or None)
            columns = tuple(cursor.keys())
            rows = cursor.all() if max_rows is None else cursor.fetchmany(max_rows)
            cursor.close()
            return columns, [tuple(row) for row in rows]
    except DBAPIError as error:
        raise _explained(error, watch, timeout_s) from error
    finally:
        connection.exec_driver_sql("PRAGMA query_only = OFF")


def _check_statement(sql: str) -> None:
    match = LEADING.match(sql)
    words = sql[match.end() if match else 0 :].split(maxsplit=1)
    if not words:
        raise UsageError("The SQL question is empty.", 'Example: orient sql P.sqlite "SELECT * FROM v_current"')
    word = re.match(r"\w*", words[0])
    if word is None or word.group().lower() not in READING_WORDS:
        raise UsageError(
            f"Only questions are allowed (SELECT, WITH, VALUES, EXPLAIN), not {words[0][:30]!r}.",
            "Rows of a project are added by orient's commands and never changed.",
        )


def _explained(error: DBAPIError, watch: Watch, timeout_s: float | None) -> BaseException:
    name, original = error_name(error), error.orig
    if name == "SQLITE_INTERRUPT" and not watch.is_stopped:
        return OrientError(f"The question took longer than {timeout_s:g} s and was stopped.", "Ask for less.")
    if name == "SQLITE_AUTH":
        return UsageError("Only questions are allowed; this statement would do something else.")
    if name == "SQLITE_TOOBIG":
        return UsageError("SQL: a value of the answer is too large.", "Ask for less.")
    is_wording = name in ("SQLITE_ERROR", "SQLITE_RANGE", "SQLITE_MISMATCH", "SQLITE_READONLY")
    if is_wording or isinstance(original, sqlite3.ProgrammingError | sqlite3.Warning):
        return UsageError(f"SQL: {str(original).rstrip('.')}.", "Tables and views are described in docs/schema.md.")
    return error
