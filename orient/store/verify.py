"""Every digest, seal and count of a project recomputed. Each function yields sentences about what is wrong."""

import sqlite3
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection
from sqlalchemy.exc import DBAPIError

from orient.errors import OrientError
from orient.store.chain import run_record_digest, selection_record_digest
from orient.store.digest import OWN_CONTENT, input_digest, rows_digest
from orient.store.error_map import error_name
from orient.store.format import Format
from orient.store.images import broken_images, broken_manifests
from orient.store.rows import stored_tables
from orient.store.runs import settings_from_json
from orient.store.stage_tables import STAGE_TABLES

Problems = Iterator[str]
SEALS = """
SELECT run_id, status, row_count, output_digest, summary, error, sealed_at, record_digest FROM main.run_seal
"""
Progress = Callable[[int, int], None]


def unsealed_runs(connection: Connection) -> Problems:
    query = "SELECT run_id FROM main.stage_run WHERE run_id NOT IN (SELECT run_id FROM main.run_seal) ORDER BY run_id"
    for run_id in connection.exec_driver_sql(query).scalars().all():
        yield f"run {run_id} has no seal"


def broken_sequences(connection: Connection) -> Problems:
    """Versions of a stage, runs and selections are numbered 1, 2, 3 ... without a gap."""
    counts = """
        SELECT 'runs', count(*), min(run_id), max(run_id) FROM main.stage_run
        UNION ALL SELECT 'selections', count(*), min(selection_id), max(selection_id) FROM main.selection
        UNION ALL
        SELECT 'versions of ' || stage, count(*), min(version), max(version) FROM main.stage_run GROUP BY stage
    """
    for what, count, first, last in connection.exec_driver_sql(counts).all():
        if count and (first, last) != (1, count):
            yield f"{what} are numbered {first} ... {last}, but there are {count}"


def strange_rows(connection: Connection) -> Problems:
    """Rows in a table that the stage of their run does not write."""
    for table in {table: None for tables in STAGE_TABLES.values() for table in tables}:
        stages = tuple(stage for stage, tables in STAGE_TABLES.items() if table in tables)
        own = f"SELECT run_id FROM main.stage_run WHERE stage IN ({', '.join('?' * len(stages))})"
        query = f"SELECT DISTINCT run_id FROM main.{table} WHERE run_id NOT IN ({own})"
        for run_id in connection.exec_driver_sql(query, stages).scalars().all():
            yield f'run {run_id} has rows in table "{table}", which its stage does not write'


def broken_selections(connection: Connection) -> Problems:
    """Selections that name no result of their stage, withdrawals of an unknown stage, and what was altered."""
    query = """
        SELECT c.selection_id, c.stage, c.run_id, c.actor, c.reason, c.selected_at, c.after_run_id, c.record_digest,
               r.stage, s.status
        FROM main.selection AS c LEFT JOIN main.stage_run AS r ON r.run_id = c.run_id
        LEFT JOIN main.run_seal AS s ON s.run_id = c.run_id ORDER BY c.selection_id
    """
    for row in connection.exec_driver_sql(query).all():
        if row[2] is None and row[1] not in STAGE_TABLES:
            yield f"selection {row[0]} withdraws {row[1]}, which is no stage"
        if row[2] is not None and (row[8] != row[1] or row[9] != "succeeded"):
            yield f"selection {row[0]} names run {row[2]}, which is no result of {row[1]}"
        if selection_record_digest(connection, tuple(row[:7])) != row[7]:
            yield f"selection {row[0]} was altered"


def broken_runs(connection: Connection, form: Format, progress: Progress | None = None) -> Problems:
    """Runs whose rows, inputs or ledger entry are not what was sealed; `progress(rows read, rows of all seals)`."""
    seals = guarded(lambda: connection.exec_driver_sql(f"{SEALS} ORDER BY run_id").all())
    if isinstance(seals, str):
        yield f"the seals cannot be read: {seals}"
        return
    count = _Count(sum(seal[2] for seal in seals if isinstance(seal[2], int)), progress)
    for seal in seals:
        yield from run_problems(connection, form, seal, count)


@dataclass(slots=True)
class _Count:
    """Rows that were read, of those that the seals tell."""

    total: int
    progress: Progress | None
    done: int = 0

    def __call__(self, rows: int) -> None:
        self.done += rows
        if self.progress is not None:
            self.progress(self.done, self.total)


def run_problems(
    connection: Connection, form: Format, seal: Sequence[Any], seen: Callable[[int], None] = lambda rows: None
) -> list[str]:
    """What is wrong with one run; `seal` = run_id ... record_digest, in stored order."""
    found = guarded(lambda: list(_run_problems(connection, form, seal, seen)))
    return [f"run {seal[0]}: {found}"] if isinstance(found, str) else found


def guarded(read: Callable[[], Any]) -> Any:
    """What `read` finds, or a sentence if the content cannot even be read."""
    try:
        return read()
    except OrientError as error:
        return error.message
    except UnicodeError:
        return "text is not UTF-8"
    except (DBAPIError, sqlite3.Error) as error:
        if error_name(error) == "SQLITE_INTERRUPT":
            raise
        told = error.orig if isinstance(error, DBAPIError) else error
        return "text is not UTF-8" if "decode" in str(told) else f"cannot be read ({told})"


def _run_problems(connection: Connection, form: Format, seal: Any, seen: Callable[[int], None]) -> Problems:
    run_id, output = seal[0], seal[3]
    header = connection.exec_driver_sql(
        "SELECT stage, stage_version, settings, input_digest FROM main.stage_run WHERE run_id = ?", (run_id,)
    ).first()
    if header is None:
        yield f"run {run_id} has a seal but no header"
        return
    tables = stored_tables(connection, run_id, header[0], form, seen)
    count = sum(map(len, tables.values()))
    if count != seal[2]:
        yield f"run {run_id}: {count} rows, seal says {seal[2]}"
    elif rows_digest(tables) != output:
        yield f"run {run_id} ({header[0]}): rows were altered after the seal"
    settings = settings_from_json(header[2], run_id)
    inputs = _input_digests(connection, run_id) or {OWN_CONTENT: output}
    if input_digest(header[0], header[1], settings, inputs) != header[3]:
        yield f"run {run_id} ({header[0]}): the input digest does not fit its inputs and settings"
    if run_record_digest(connection, tuple(seal[:7])) != seal[7]:
        yield f"run {run_id} ({header[0]}): header, inputs or seal were altered"


def _input_digests(connection: Connection, run_id: int) -> dict[str, str]:
    query = """
        SELECT i.role, s.output_digest FROM main.run_input AS i JOIN main.run_seal AS s ON s.run_id = i.input_run_id
        WHERE i.run_id = ?
    """
    return {row[0]: row[1] for row in connection.exec_driver_sql(query, (run_id,)).all()}


def all_problems(connection: Connection, form: Format, progress: Progress | None = None) -> Problems:
    yield from unsealed_runs(connection)
    yield from broken_sequences(connection)
    yield from strange_rows(connection)
    yield from broken_runs(connection, form, progress)
    yield from broken_selections(connection)
    yield from broken_images(connection)
    yield from broken_manifests(connection)
