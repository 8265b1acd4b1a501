"""The tables are those of models.py, the expected text is that of a fresh file, and only the store touches SQLite."""

import json
import re
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest
from sqlalchemy import create_engine

from orient import models
from orient.store import creation, guards
from orient.store.format import current_format, format_from_json, json_from_format
from orient.store.project import open_project
from orient.store.stage_tables import LEDGER_TABLES, STAGE_TABLES
from orient.store.views import view_texts
from orient.store.watch import Watch

ROOT = Path(__file__).parents[2]


def test_migrations_make_the_tables_of_the_models() -> None:
    engine = create_engine("sqlite://")
    models.Base.metadata.create_all(engine)
    with engine.connect() as connection:
        rows = connection.exec_driver_sql("SELECT type, name, tbl_name, sql FROM sqlite_schema").all()
    made = {(row[0], row[1], row[2], row[3] and row[3].strip()) for row in rows}
    migrated = {item for item in current_format().objects if item[0] in ("table", "index") and "alembic" not in item[1]}
    assert made == migrated


def test_expected_schema_is_that_of_a_fresh_file(tmp_path: Path) -> None:
    fresh = creation.expected_format(tmp_path, models.SCHEMA_VERSION, models.APPLICATION_ID)
    assert json_from_format(fresh) == json_from_format(current_format()), "run write_expected_schema()"


def test_expected_schema_survives_its_file_format() -> None:
    form = current_format()
    assert format_from_json(json_from_format(form)) == form


def test_every_table_has_its_stage() -> None:
    listed = {table for tables in STAGE_TABLES.values() for table in tables} | set(LEDGER_TABLES)
    assert sorted(listed) == sorted(models.Base.metadata.tables)


def test_every_table_is_strict_and_guarded() -> None:
    form = current_format()
    for kind, name, _, sql in form.objects:
        if kind == "table" and name != "alembic_version":
            assert str(sql).endswith("STRICT"), name
    triggers = form.names_of("trigger")
    for table in form.tables:
        assert {f"guard_{table}_update", f"guard_{table}_delete"} <= triggers


def test_views_and_their_columns_are_described(full: Path) -> None:
    texts = {text.name: text for text in view_texts()}
    assert texts.keys() == current_format().names_of("view")
    with open_project(full) as project:
        for name, text in texts.items():
            columns, _ = project.query(f"SELECT * FROM {name}")
            assert columns == tuple(text.columns), name


def test_cte_names_of_the_views_are_listed(full: Path) -> None:
    """A name that the authorizer does not know would make a view unusable on a connection of the program."""
    with open_project(full) as project, project.snapshot() as connection:
        for text in view_texts():
            connection.exec_driver_sql(f"SELECT * FROM {text.name}").all()
    written = set(
        re.findall(r"(?:WITH RECURSIVE|WITH|\),)\s+(\w+)\s*(?:\([\w, ]*\))?\s+AS \(", guards.VIEWS_FILE.read_text())
    )
    assert written == guards.CTE_NAMES


def test_stored_views_read_the_same_without_orient(full: Path) -> None:
    with open_project(full) as project, closing(sqlite3.connect(full)) as bare:
        for text in view_texts():
            assert (
                project.query(f"SELECT * FROM {text.name}")[1] == bare.execute(f"SELECT * FROM {text.name}").fetchall()
            )


def test_only_the_store_knows_sqlite() -> None:
    pattern = re.compile(r"\b(import sqlite3|from sqlite3|create_engine|alembic\.command|from alembic)\b")
    for file in (ROOT / "orient").rglob("*.py"):
        if "store" not in file.parts:
            assert not pattern.search(file.read_text(encoding="utf-8")), file


def test_reading_loads_no_heavy_module(full: Path) -> None:
    code = """
import json, sys
from orient.store.project import open_project
with open_project(sys.argv[1]) as project:
    project.query("SELECT * FROM v_stale"); project.heads()
heavy = ("numpy", "scipy", "alembic", "pyproj", "orient.models", "sqlalchemy.orm", "pandas")
print(json.dumps([name for name in heavy if name in sys.modules]))
"""
    done = subprocess.run([sys.executable, "-c", code, str(full)], capture_output=True, text=True, check=True, cwd=ROOT)
    assert json.loads(done.stdout) == []


def test_alembic_refuses_to_run_on_its_own() -> None:
    from alembic import command

    with pytest.raises(SystemExit, match="orient new"):
        command.current(creation._config(creation.migrations_folder()))


def test_an_unknown_trigger_or_view_may_not_run() -> None:
    watch = Watch("write", frozenset({"ours"}))
    assert watch.authorize(sqlite3.SQLITE_READ, "photo", "name", "main", "ours") == sqlite3.SQLITE_OK
    assert watch.authorize(sqlite3.SQLITE_READ, "photo", "name", "main", "theirs") == sqlite3.SQLITE_DENY
    assert watch.authorize(sqlite3.SQLITE_DELETE, "photo", None, "main", None) == sqlite3.SQLITE_DENY
