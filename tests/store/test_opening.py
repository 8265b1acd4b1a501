"""Every file that is not a healthy project has its own clear message (RELIABILITY.md 7 D and 6.2), and soon."""

import os
import re
import shutil
import socket
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from orient.errors import OrientError, ProjectError, UsageError
from orient.models import SCHEMA_VERSION
from orient.store.check import check_project
from orient.store.errors import NeedsRecovery
from orient.store.project import open_project
from tests.store.made import INPUTS, new_run

JOURNAL_MAGIC = bytes.fromhex("d9d505f920a163d7")
Damage = Callable[[Path], object]


def patch(offset: int, content: bytes) -> Damage:
    def damage(path: Path) -> None:
        whole = bytearray(path.read_bytes())
        whole[offset : offset + len(content)] = content
        path.write_bytes(whole)

    return damage


def sql(*statements: str) -> Damage:
    """What a stranger does with another program."""

    def damage(path: Path) -> None:
        with closing(sqlite3.connect(path, isolation_level=None)) as connection:
            connection.execute("PRAGMA foreign_keys = OFF")
            for statement in statements:
                connection.execute(statement)

    return damage


def schema(old: str, new: str, table: str) -> Damage:
    change = f"UPDATE sqlite_schema SET sql = replace(sql, '{old}', '{new}') WHERE name = '{table}'"
    return sql("PRAGMA writable_schema = ON", change)


def added(kind: str, name: str, table: str, text: str) -> Damage:
    """A row of the schema table that SQLite itself would not write."""
    row = f"INSERT INTO sqlite_schema VALUES ('{kind}', '{name}', '{table}', 0, 'CREATE {text}')"
    return sql("PRAGMA writable_schema = ON", row, "PRAGMA schema_version = 9999")


def unguarded(*statements: str) -> Damage:
    """A change of rows that puts the guards back exactly as they were."""

    def damage(path: Path) -> None:
        with closing(sqlite3.connect(path, isolation_level=None)) as connection:
            connection.execute("PRAGMA foreign_keys = OFF")
            connection.execute("BEGIN")
            guards = connection.execute("SELECT name, sql FROM sqlite_schema WHERE type = 'trigger'").fetchall()
            for name, _ in guards:
                connection.execute(f"DROP TRIGGER {name}")
            for statement in statements:
                connection.execute(statement)
            for _, text in guards:
                connection.execute(text)
            connection.execute("COMMIT")

    return damage


def beside(tail: str, content: bytes = b"") -> Damage:
    return lambda path: Path(f"{path}{tail}").write_bytes(content)


def instead(make: Damage) -> Damage:
    def damage(path: Path) -> None:
        path.unlink()
        make(path)

    return damage


def make_socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(str(path))


def truncate(size: int) -> Damage:
    return lambda path: os.truncate(path, size)


def wal_mode(path: Path) -> None:
    sql("PRAGMA journal_mode = WAL")(path)


REFUSED: dict[str, tuple[Damage, str]] = {
    "D1 missing": (lambda path: path.unlink(), "no such project: .*house.orient"),
    "D2 empty": (truncate(0), "is empty"),
    "D3 text": (lambda path: path.write_text("a photo\n" * 20), "not an orient project"),
    "D3 short text": (lambda path: path.write_text("hi"), "not an orient project"),
    "D3 image": (lambda path: path.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(200)), "not an orient project"),
    "D4 other program": (patch(68, bytes.fromhex("47504b47")), "another program.*GeoPackage"),
    "D4 plain SQLite": (patch(68, bytes(4)), "belongs to another program"),
    "D5 newer": (patch(60, (7).to_bytes(4, "big")), f"newer orient .format 7, this one knows {SCHEMA_VERSION}"),
    "D7 zero": (patch(60, bytes(4)), "unknown format"),
    "D7 negative": (patch(60, b"\xff\xff\xff\xfe"), "unknown format"),
    "D8 no revision": (unguarded("DELETE FROM alembic_version"), "upgrade was not finished"),
    "D8 two revisions": (unguarded("INSERT INTO alembic_version VALUES ('0001')"), "upgrade was not finished"),
    "D8 other revision": (unguarded("UPDATE alembic_version SET version_num = 'x'"), "upgrade was not finished"),
    "D9 folder": (instead(lambda path: path.mkdir()), "not a regular file"),
    "D9 fifo": (instead(os.mkfifo), "not a regular file"),
    "D9 socket": (instead(make_socket), "not a regular file"),
    "D10 dangling link": (instead(lambda path: path.symlink_to("nowhere")), "no such project"),
    "D10 loop": (instead(lambda path: path.symlink_to(path)), "too many links"),
    "D12 cut in the header": (truncate(60), "damaged"),
    "D12 cut": (truncate(50_000), "damaged"),
    "D12 cut in a page": (truncate(70_001), "damaged"),
    "D14 page size": (patch(16, (1000).to_bytes(2, "big")), "damaged header"),
    "D14 payload fraction": (patch(21, b"\x41"), "damaged header"),
    "D14 mixed versions": (patch(18, b"\x01\x02"), "damaged header"),
    "D15 UTF-16": (patch(56, (2).to_bytes(4, "big")), "text encoding"),
    "D16 WAL": (wal_mode, "WAL mode"),
    "D17 wal beside": (beside("-wal", b"x"), "-wal file lies beside"),
    "D17 shm beside": (beside("-shm"), "-shm file lies beside"),
    "D19 super-journal": (beside("-journal", JOURNAL_MAGIC + bytes(600) + b"/victim" + JOURNAL_MAGIC), "names another"),
    "D20 journal link": (lambda path: Path(f"{path}-journal").symlink_to(path), "not a regular file"),
    "D20 journal folder": (lambda path: Path(f"{path}-journal").mkdir(), "not a regular file"),
    "D20 journal fifo": (lambda path: os.mkfifo(f"{path}-journal"), "not a regular file"),
    "D22 table": (sql("CREATE TABLE extra (a)"), "never makes: table 'extra'"),
    "D22 view": (sql("CREATE VIEW extra AS SELECT 1"), "never makes: view 'extra'"),
    "D22 trigger": (
        sql("CREATE TRIGGER extra AFTER INSERT ON photo BEGIN SELECT load_extension('x'); END"),
        "never makes: trigger 'extra'",
    ),
    "D22 deleting trigger": (
        sql("CREATE TRIGGER t AFTER INSERT ON stage_run BEGIN DELETE FROM photo; END"),
        "never makes: trigger 't'",
    ),
    "D22 trigger named as statistics": (
        added("trigger", "sqlite_stat1", "photo", "TRIGGER sqlite_stat1 AFTER INSERT ON photo BEGIN SELECT 1; END"),
        "never makes: trigger 'sqlite_stat1'",
    ),
    "D22 view named as statistics": (
        added("view", "sqlite_stat1", "sqlite_stat1", "VIEW sqlite_stat1 AS SELECT 1 AS tbl, 2 AS idx, 3 AS stat"),
        "never makes: view 'sqlite_stat1'",
    ),
    "D22 guard twice": (
        added(
            "trigger",
            "guard_photo_delete",
            "photo",
            "TRIGGER IF NOT EXISTS guard_photo_delete BEFORE DELETE ON photo BEGIN SELECT 1; END",
        ),
        "never makes: trigger 'guard_photo_delete' more than once",
    ),
    "D22 index": (sql("CREATE INDEX extra ON photo (name)"), "never makes: index 'extra'"),
    "D22 virtual table": (sql("CREATE VIRTUAL TABLE extra USING fts5 (a)"), "never makes"),
    "D22 generated column": (
        sql("CREATE TABLE extra (a, b AS (hex(zeroblob(400000000))))"),
        "never makes: table 'extra'",
    ),
    "D23 guard": (sql("DROP TRIGGER guard_photo_update"), "missing: trigger 'guard_photo_update'"),
    "D23 view": (sql("DROP VIEW v_stale"), "missing: view 'v_stale'"),
    "D24 CHECK": (schema("BETWEEN -1e15", "BETWEEN -9e99", "image_point"), "differs in table 'image_point'"),
    "D24 STRICT": (schema("STRICT", "", "image_point"), "differs in table 'image_point'"),
    "D24 column": (sql("ALTER TABLE photo ADD COLUMN extra TEXT"), "differs in table 'photo'"),
    "D24 garbage": (schema("CREATE", "CRATE", "image_point"), "damaged|differs"),
    "view of 1e9 rows for a table": (
        sql(
            "DROP TABLE cofactor",
            "CREATE VIEW cofactor AS WITH RECURSIVE r(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM r) SELECT * FROM r",
        ),
        "never makes",
    ),
    "root page": (
        sql("PRAGMA writable_schema = ON", "UPDATE sqlite_schema SET rootpage = 999999 WHERE name = 'photo'"),
        "damaged",
    ),
    "two tables on one page": (
        sql(
            "PRAGMA writable_schema = ON",
            "UPDATE sqlite_schema SET rootpage = (SELECT rootpage FROM sqlite_schema WHERE name = 'photo') "
            "WHERE name = 'image_point'",
        ),
        "damaged",
    ),
    "D25 orphan rows": (
        unguarded("INSERT INTO model_point (run_id, zone, point, x, y, z) VALUES (99, 'z', 'p', 0, 0, 0)"),
        "dangling references",
    ),
}
INFINITY = unguarded("PRAGMA ignore_check_constraints = ON", "UPDATE model_point SET x = 9e999")


@pytest.mark.parametrize("name", REFUSED)
@pytest.mark.parametrize("mode", ["read", "write"])
def test_refused(full: Path, name: str, mode: str) -> None:
    damage, words = REFUSED[name]
    damage(full)
    before = sorted(full.parent.iterdir())
    started = time.monotonic()
    with pytest.raises(OrientError) as error:
        open_project(full, mode)  # type: ignore[arg-type]
    assert re.search(words, error.value.message), error.value.message
    assert error.value.exit_code == (2 if "no such project" in words else 3)
    assert time.monotonic() - started < 3
    assert sorted(full.parent.iterdir()) == before


NEEDS_DIGEST: dict[str, tuple[Damage, str]] = {
    "D25 no seal": (
        unguarded("INSERT INTO stage_run SELECT 13, stage, 2, 1, '{}', '', '', '', '', '' FROM stage_run LIMIT 1"),
        "run 13 has no seal",
    ),
    "D25 forged run": (
        unguarded(
            "INSERT INTO stage_run SELECT 13, stage, 2, 1, '{}', '', '', '', '', '' FROM stage_run LIMIT 1",
            "INSERT INTO run_seal SELECT 13, status, 0, output_digest, '', '', '', '' FROM run_seal WHERE run_id = 1",
        ),
        "run 13",
    ),
    "D26 count": (
        unguarded("UPDATE run_seal SET row_count = 1000000000000 WHERE run_id = 7"),
        "seal says 1000000000000",
    ),
    "D29 deep settings": (
        unguarded(f"UPDATE stage_run SET settings = '{'[' * 50_000}' WHERE run_id = 7"),
        "settings of run 7 are not valid",
    ),
    "D29 settings are a list": (
        unguarded("UPDATE stage_run SET settings = '[]' WHERE run_id = 7"),
        "settings of run 7",
    ),
    "D30 not UTF-8": (
        unguarded("UPDATE photo SET name = CAST(x'ff41' AS TEXT)"),
        "run 1: text is not UTF-8",
    ),
    "D30 not UTF-8 in the ledger": (
        unguarded("UPDATE stage_run SET reason = CAST(x'ff41' AS TEXT) WHERE run_id = 2"),
        "run 2: text is not UTF-8",
    ),
    "value": (unguarded("UPDATE orientation SET X_S_m = X_S_m + 1e-9"), "rows were altered"),
    "row removed": (unguarded("DELETE FROM equation"), "rows, seal says"),
    "row added": (
        unguarded(
            "INSERT INTO model_point (run_id, zone, point, x, y, z) SELECT 1, zone, point, x, y, z FROM model_point"
        ),
        "does not write",
    ),
    "reason": (unguarded("UPDATE stage_run SET reason = 'other' WHERE run_id = 3"), "run 3 .* were altered"),
    "summary": (unguarded("UPDATE run_seal SET summary = 'other' WHERE run_id = 3"), "run 3 .* were altered"),
    "input": (unguarded("UPDATE run_input SET input_run_id = 1 WHERE run_id = 11"), "run 11"),
    "selection": (unguarded("UPDATE selection SET actor = 'other' WHERE selection_id = 2"), "selection 2 was altered"),
    "selection moved": (unguarded("UPDATE selection SET run_id = 3 WHERE selection_id = 2"), "is no result of"),
    "withdrawal of no stage": (
        unguarded("UPDATE selection SET stage = 'other', run_id = NULL WHERE selection_id = 2"),
        "withdraws other, which is no stage",
    ),
    "selection removed": (unguarded("DELETE FROM selection WHERE selection_id = 5"), "selections are numbered"),
    "event": (unguarded("UPDATE run_event SET message = 'x' WHERE run_id = 4"), "rows were altered"),
}


@pytest.mark.parametrize("name", NEEDS_DIGEST)
def test_found_by_check(full: Path, name: str) -> None:
    damage, words = NEEDS_DIGEST[name]
    damage(full)
    report = check_project(full)
    assert not report.ok
    found = "\n".join(line.detail for line in report.lines if not line.ok)
    assert re.search(words, found), found


def test_infinity_is_refused_by_writers_and_by_check(full: Path) -> None:
    """SQLite forgets CHECK constraints on a read-only connection, so a reader is told by `orient check` only."""
    INFINITY(full)
    with pytest.raises(ProjectError, match="CHECK constraint failed in model_point"):
        open_project(full, "write")
    assert not check_project(full).ok


ACCEPTED: dict[str, Damage] = {
    "symbolic link": lambda path: path.rename(path.with_name("real")) and path.symlink_to("real"),
    "page size 65536": sql("PRAGMA page_size = 65536", "VACUUM"),
    "statistics": sql("ANALYZE"),
    "stale journal": beside("-journal", bytes(512)),
    "empty journal": beside("-journal"),
}


@pytest.mark.parametrize("name", ACCEPTED)
def test_accepted(full: Path, name: str) -> None:
    ACCEPTED[name](full)
    assert check_project(full).ok
    with open_project(full, "write") as project:
        assert project.append(new_run(project, "photo", 0.25)).version == 2
    assert not Path(f"{full}-journal").exists()


def test_twenty_thousand_tables_are_refused_soon(full: Path) -> None:
    sql(*(f"CREATE TABLE t{number} (a)" for number in range(300)))(full)
    with pytest.raises(ProjectError, match="instead of"):
        open_project(full)


def test_hard_links_are_a_warning(full: Path) -> None:
    os.link(full, full.with_name("second"))
    with open_project(full) as project:
        assert "2 names" in project.warnings[0]


def test_paths_inside_are_only_text(full: Path) -> None:
    with open_project(full) as project:
        assert project.read_tables(1)["photo"][0]["image_file"] == "image_file"


@pytest.mark.parametrize("path", ["", "a\0b"])
def test_names_that_are_none(path: str) -> None:
    with pytest.raises(UsageError):
        open_project(path)


def test_read_only_is_said_before_computing(full: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda *_: False)
    with open_project(full) as project:
        assert len(project.heads()) == len(INPUTS)
    with pytest.raises(ProjectError, match="cannot be written"):
        open_project(full, "write")


def leave_hot_journal(path: Path, folder: Path) -> Path:
    """A copy of a project as a killed command leaves it: pages written, the journal not removed."""
    code = """
import sqlite3, sys, os
connection = sqlite3.connect(sys.argv[1], isolation_level=None)
connection.execute("PRAGMA cache_size = 1"); connection.execute("PRAGMA synchronous = OFF")
connection.execute("BEGIN IMMEDIATE")
rows = ((n, "s%d" % n, 1, 1, "{}", "", "", "", "", "") for n in range(13, 3000))
connection.executemany("INSERT INTO stage_run VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)", rows)
os._exit(9)
"""
    subprocess.run([sys.executable, "-c", code, str(path)], check=False)
    target = folder / path.name
    shutil.copy(path, target)
    shutil.copy(f"{path}-journal", f"{target}-journal")
    content = bytearray(Path(f"{target}-journal").read_bytes())
    assert content
    content[:8] = JOURNAL_MAGIC
    Path(f"{target}-journal").write_bytes(content)
    return target


@pytest.mark.parametrize("mode", ["read", "write"])
def test_hot_journal_is_undone(full: Path, tmp_path: Path, mode: str) -> None:
    (tmp_path / "other").mkdir()
    hot = leave_hot_journal(full, tmp_path / "other")
    with open_project(hot, mode) as project:  # type: ignore[arg-type]
        assert "recovered" in project.warnings[-1]
        assert len(project.runs()) == len(INPUTS)
    assert check_project(hot).ok
    assert [file.name for file in hot.parent.iterdir()] == [hot.name]


def test_error_map_names_a_needed_recovery(full: Path) -> None:
    from orient.store.error_map import explain
    from orient.store.watch import Watch

    error = sqlite3.OperationalError("attempt to write a readonly database")
    error.sqlite_errorname = "SQLITE_READONLY_ROLLBACK"
    assert isinstance(explain(error, full, Watch()), NeedsRecovery)
