"""Nothing that is stored can be changed or deleted: by us, by REPLACE, by a bug, on any table."""

import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from sqlalchemy import REAL, Connection
from sqlalchemy.exc import DBAPIError, IntegrityError

from orient.models import Base
from orient.store import gate
from orient.store.connection import hardened
from orient.store.errors import OurFault, Replaced, StorageError
from orient.store.format import current_format
from orient.store.gate import Gated, pass_gate
from orient.store.preflight import preflight
from orient.store.project import open_project
from orient.store.stage_tables import STAGE_TABLES
from orient.store.watch import Watch
from tests.promises import Promise
from tests.store.made import EVIDENCE, new_run, row_of

TABLES = sorted(current_format().tables)
STATEMENTS = {
    "update": "UPDATE {table} SET {column} = {column}",
    "delete": "DELETE FROM {table}",
    "replace": "REPLACE INTO {table} SELECT * FROM {table}",
    "upsert": "INSERT INTO {table} SELECT * FROM {table} WHERE true ON CONFLICT DO UPDATE SET {column} = {column}",
    "late": "INSERT OR IGNORE INTO {table} SELECT * FROM {table}",
}
NO_SEAL = ("selection", "alembic_version")


@pytest.fixture(scope="module")
def verified(full_once: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project with a row in every table, image, manifest and verification too."""
    path = Path(shutil.copy(full_once, tmp_path_factory.mktemp("verified") / "house.orient"))
    with open_project(path, "write") as project:
        for stage in EVIDENCE:
            project.append(replace(new_run(project, stage), select=False))
    return path


@pytest.fixture(scope="module")
def writer(verified: Path) -> Iterator[Gated]:
    """A connection as the program has it, but without the authorizer's own refusal of UPDATE and DELETE."""
    form = current_format()
    gated = pass_gate(preflight(verified, form), "write", form)
    gated.watch.phase = "setup"
    yield gated
    gated.close()


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("action", STATEMENTS)
def test_guards_of_an_open_project_refuse(writer: Gated, table: str, action: str, promise: Promise) -> None:
    if action == "late" and table in NO_SEAL:
        pytest.skip("has no run that could be sealed")
    column = current_format().tables[table].names[-1]
    statement = STATEMENTS[action].format(table=table, column=f'"{column}"')
    refused = pytest.raises(IntegrityError, match=r"never|sealed|upgrade|counted|only")
    with promise("F10").trial(statement), refused, writer.connection.begin():
        writer.connection.exec_driver_sql(statement)


@pytest.mark.parametrize("table", TABLES)
def test_stored_guards_refuse_too(verified: Path, table: str, promise: Promise) -> None:
    with closing(sqlite3.connect(verified)) as bare:
        for statement in (f"DELETE FROM {table}", f"UPDATE {table} SET rowid = rowid"):
            with promise("F10").trial(statement), pytest.raises(sqlite3.IntegrityError, match="never"):
                bare.execute(statement)


@pytest.mark.parametrize("dropped", ["TRIGGER guard_photo_delete", "VIEW v_current"])
def test_nothing_is_done_without_the_guards_and_views_that_were_compared(
    full: Path, dropped: str, promise: Promise
) -> None:
    with open_project(full, "write") as project:
        with closing(sqlite3.connect(full)) as stranger:
            stranger.execute(f"DROP {dropped}")
        with promise("F10").trial(f"read without {dropped}"), pytest.raises(Replaced, match="altered the schema"):
            project.heads()
        with promise("F10").trial(f"append without {dropped}"), pytest.raises(Replaced, match="altered the schema"):
            project.append(new_run(project, "photo"))


def test_a_look_at_the_schema_that_fails_leaves_no_transaction_open(
    full: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else the next reader would go on in it without looking."""

    def fail(connection: Connection) -> int:
        raise StorageError("the disk cannot be read")

    with open_project(full) as project:
        with monkeypatch.context() as patch, pytest.raises(StorageError):
            patch.setattr(gate, "schema_version_of", fail)
            project.heads()
        with closing(sqlite3.connect(full)) as stranger:
            stranger.execute("DROP VIEW v_current")
        with pytest.raises(Replaced, match="altered the schema"):
            project.heads()


@pytest.mark.parametrize("statement", ["SELECT * FROM v_current", "INSERT INTO photo SELECT * FROM photo"])
def test_nothing_of_the_file_runs_before_it_is_compared(full: Path, statement: str, promise: Promise) -> None:
    refused = pytest.raises(sqlite3.DatabaseError, match=r"prohibited|not authorized|view|UNIQUE")  # not "sealed"
    with closing(hardened(full, "write", Watch())) as connection, promise("S4").trial(statement), refused:
        connection.execute(statement)


@pytest.mark.parametrize(
    "statement", ["DROP TABLE photo", "DELETE FROM photo", "CREATE TABLE t (a)", "ATTACH 'x' AS y"]
)
def test_the_authorizer_refuses_before_any_guard(full: Path, statement: str) -> None:
    form = current_format()
    gated = pass_gate(preflight(full, form), "write", form)
    try:
        with pytest.raises(DBAPIError, match="not authorized"), gated.connection.begin():
            gated.connection.exec_driver_sql(statement)
    finally:
        gated.close()


@pytest.mark.parametrize(
    ("statement", "words"),
    [
        ("INSERT INTO selection VALUES (99, 'refine', 1, '', '', '', 1, '')", "sealed result of the same stage"),
        ("INSERT INTO stage_run VALUES (99, 'photo', 7, 1, '', '', '', '', '', '')", "without a gap"),
        ("INSERT INTO run_input VALUES (99, 'photo', 98)", "only sealed results"),
    ],
    ids=["selection of a stranger", "gap in the versions", "input that is no result"],
)
def test_the_ledger_stays_sound(writer: Gated, statement: str, words: str) -> None:
    with pytest.raises(IntegrityError, match=words), writer.connection.begin():
        writer.connection.exec_driver_sql(statement)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 1e16, "0.5", b"1", True + 0j], ids=str)
def test_numbers_that_are_none_are_not_stored(value: object, promise: Promise) -> None:
    from orient.store.plain import plain_value

    with promise("F13").trial(str(value)), pytest.raises(OurFault):
        plain_value(value, "REAL", "photo", "f_mm")


def test_strict_tables_refuse_what_slips_through(writer: Gated, promise: Promise) -> None:
    insert = "INSERT INTO stage_run VALUES (99, 'x', 1, 1, '', '', '', '', '', '')"
    for value in (float("nan"), float("inf"), "text"):
        kept = promise("F13").trial(str(value))
        with kept, pytest.raises(IntegrityError), writer.connection.begin():
            writer.connection.exec_driver_sql(insert)
            writer.connection.exec_driver_sql(
                "INSERT INTO model_point (run_id, zone, point, x, y, z) VALUES (99, 'z', 'p', ?, 0, 0)", (value,)
            )


NUMBERS = {table.name for table in Base.metadata.sorted_tables if any(isinstance(c.type, REAL) for c in table.columns)}
RESULT_TABLES = {table: stage for stage, tables in STAGE_TABLES.items() for table in tables if table in NUMBERS}
OPEN_A_RUN = """
INSERT INTO stage_run SELECT (SELECT max(run_id) + 1 FROM stage_run), stage, version + 1, stage_version, settings,
    input_digest, actor, reason, tool_version, started_at
FROM stage_run WHERE stage = ? ORDER BY version DESC LIMIT 1
"""


@pytest.mark.parametrize("table", RESULT_TABLES)
def test_no_numeric_column_takes_what_is_no_number(table: str, writer: Gated, promise: Promise) -> None:
    """Infinity and text in every numeric column, NaN (which binds as NULL) in every one that must have a value."""
    model, kept, connection = Base.metadata.tables[table], promise("F13"), writer.connection
    sound = row_of(model)
    with connection.begin() as undone:
        connection.exec_driver_sql("PRAGMA defer_foreign_keys = ON")
        connection.exec_driver_sql(OPEN_A_RUN, (RESULT_TABLES[table],))
        sound = {"run_id": connection.exec_driver_sql("SELECT max(run_id) FROM stage_run").scalar_one(), **sound}
        insert = f"INSERT INTO {table} ({', '.join(sound)}) VALUES ({', '.join('?' * len(sound))})"
        for column in (column for column in model.columns if isinstance(column.type, REAL)):
            for value in (float("inf"), float("-inf"), "text", *([] if column.nullable else [float("nan")])):
                with kept.trial(f"{table}.{column.name} = {value}"), pytest.raises(IntegrityError):
                    connection.exec_driver_sql(insert, tuple({**sound, column.name: value}.values()))
        connection.exec_driver_sql(insert, tuple(sound.values()))  # with numbers it is taken
        undone.rollback()
