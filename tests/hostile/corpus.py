"""Hostile project files, made anew for each test and never stored: what a stranger can put into or beside a file.

Those of tests/store/test_opening.py belong to them; here are the ones that aim at somebody: at other files, at memory,
at time. Each is called with the path of a sound project, and changes it or what lies beside it.
"""

import os
import shutil
import sqlite3
import struct
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path

from tests.store.test_opening import JOURNAL_MAGIC, NEEDS_DIGEST, REFUSED, Damage, sql, unguarded

PAGE, SECTOR = 4096, 512
LOCK_PAGE = 2**30 // PAGE + 1
VICTIM, LETTER = "victim.txt", "a letter that nobody else has\n"
ENDLESS = "WITH RECURSIVE r(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM r LIMIT 1000000000) SELECT n FROM r"


def super_journal(path: Path) -> None:
    """A hot journal that names the victim as its super-journal: SQLite before 2026 deletes the victim on opening."""
    name = str(path.with_name(VICTIM)).encode()
    header = JOURNAL_MAGIC + struct.pack(">IIIII", 0, 1, path.stat().st_size // PAGE, SECTOR, PAGE)
    signed = sum(byte if byte < 128 else byte - 256 for byte in name) & 0xFFFFFFFF
    tail = struct.pack(">I", LOCK_PAGE) + name + struct.pack(">II", len(name), signed) + JOURNAL_MAGIC
    Path(f"{path}-journal").write_bytes(header.ljust(SECTOR, b"\0") + tail)


def stray_wal(path: Path) -> None:
    """The log of another file with the same pages, in which the photo has another name."""
    other = path.with_name("other.sqlite")
    shutil.copy(path, other)
    with closing(sqlite3.connect(other, isolation_level=None)) as writer:
        writer.execute("PRAGMA journal_mode = WAL")
        writer.execute("PRAGMA wal_autocheckpoint = 0")
        writer.execute("DROP TRIGGER guard_photo_update")
        writer.execute("UPDATE photo SET name = 'replaced by a stray log'")
        shutil.copy(f"{other}-wal", f"{path}-wal")
    other.unlink()


def linked(tail: str) -> Damage:
    """A side file that is a link to the victim."""
    return lambda path: Path(f"{path}{tail}").symlink_to(VICTIM)


def fifo(tail: str) -> Damage:
    return lambda path: os.mkfifo(f"{path}{tail}")


def device(path: Path) -> None:
    path.unlink()
    path.symlink_to("/dev/zero")


def edited(name: str, old: str, new: str) -> Damage:
    """The stored text of one table, changed without SQLite's consent."""
    return sql(
        "PRAGMA writable_schema = ON",
        f"UPDATE sqlite_schema SET sql = replace(sql, '{old}', '{new}') WHERE name = '{name}'",
    )


def emptied_fts(path: Path) -> None:
    """A search index whose shadow tables are empty: integrity_check calls it sound."""
    sql(
        "CREATE VIRTUAL TABLE search USING fts5 (a)",
        "INSERT INTO search VALUES ('x')",
        "PRAGMA writable_schema = ON",
        "DELETE FROM search_data",
    )(path)


def statistics(path: Path) -> None:
    """Numbers that lie to the planner of queries."""
    sql("ANALYZE", "UPDATE sqlite_stat1 SET stat = '1000000000000 1000000000000'", "DELETE FROM sqlite_stat1 LIMIT 0")(
        path
    )


def declared(offset: int, value: int) -> Damage:
    """A count in the header that is not true."""

    def damage(path: Path) -> None:
        content = bytearray(path.read_bytes())
        content[offset : offset + 4] = value.to_bytes(4, "big")
        path.write_bytes(content)

    return damage


def large_text(table: str, column: str, size: int) -> Damage:
    """A value of a column of ours that is larger than anything orient writes."""
    return unguarded(f"UPDATE {table} SET {column} = CAST(zeroblob({size}) AS TEXT) WHERE run_id = 1")


def large_blob(size: int) -> Damage:
    part = f"INSERT INTO image_part VALUES (1, 1, zeroblob({size}))"
    return unguarded("PRAGMA ignore_check_constraints = ON", part)


def view(name: str, text: str) -> Damage:
    return sql(f"DROP VIEW {name}", f"CREATE VIEW {name} AS {text}")


def trigger(body: str) -> Damage:
    return sql(f"CREATE TRIGGER t AFTER INSERT ON selection BEGIN {body}; END")


CROSS = " CROSS JOIN ".join(["equation AS e"] + [f"sqlite_schema AS s{number}" for number in range(6)])
"""450^6 rows."""
NAME = "name TEXT NOT NULL"

AIMED: Mapping[str, Damage] = {
    "super-journal": super_journal,
    "stray log": stray_wal,
    "journal is a link": linked("-journal"),
    "log is a link": linked("-wal"),
    "index of the log is a link": linked("-shm"),
    "journal is a pipe": fifo("-journal"),
    "log is a pipe": fifo("-wal"),
    "link to a device": device,
    "view that loads code": view("v_current", "SELECT load_extension('/tmp/x.so') AS stage"),
    "view of a token maker": view("v_current", "SELECT fts3_tokenizer('simple') AS stage"),
    "view of pragmas": view("v_current", "SELECT name AS stage FROM pragma_table_list"),
    "view of pages": view("v_current", "SELECT name AS stage FROM dbstat"),
    "view without end": view("v_current", ENDLESS),
    "view of a great product": view("v_current", f"SELECT count(*) AS stage FROM {CROSS}"),
    "trigger that loads code": trigger("SELECT load_extension('/tmp/x.so')"),
    "trigger that deletes": trigger("DELETE FROM run_event"),
    "trigger without end": trigger(f"INSERT INTO run_event SELECT 1, n, 'info', '', '', '', NULL FROM ({ENDLESS})"),
    "generated column of 800 MB": sql(
        "ALTER TABLE photo ADD COLUMN big TEXT GENERATED ALWAYS AS (hex(zeroblob(400000000))) VIRTUAL"
    ),
    "check of 800 MB": edited("photo", NAME, f"{NAME} CHECK (length(hex(zeroblob(400000000))))"),
    "default of 800 MB": edited("photo", NAME, f"{NAME} DEFAULT (hex(zeroblob(400000000)))"),
    "index on an expression": sql("CREATE INDEX extra ON photo (hex(name))"),
    "search index without its tables": emptied_fts,
    "tree index": sql("CREATE VIRTUAL TABLE extra USING rtree (a, b, c)"),
    "table text of 20 MB": edited("photo", "STRICT", "STRICT /* ' || hex(zeroblob(10000000)) || ' */"),
    "name with control codes": sql('CREATE TABLE "\x1b[2J\x07\u202e" (a)'),
    "lying statistics": statistics,
    "page count 4 thousand million": declared(28, 2**32 - 1),
    "free pages 4 thousand million": declared(36, 2**32 - 1),
    "first free page beyond the end": declared(32, 2**31),
    "incremental vacuum": declared(52, 5),
    "text of 70 MB": large_text("photo", "name", 70_000_000),
    "reason of 70 MB": large_text("stage_run", "reason", 70_000_000),
    "bytes of 70 MB": large_blob(70_000_000),
}
HUGE: Mapping[str, Damage] = {
    "text of 150 MB": large_text("photo", "name", 150_000_000),
    "bytes of 300 MB": large_blob(300_000_000),
    "many bytes of 60 MB": unguarded(
        "PRAGMA ignore_check_constraints = ON",
        *(f"INSERT INTO image_part VALUES (1, {seq}, zeroblob(60000000))" for seq in range(1, 8)),
    ),
}
"""Those that take some hundred megabytes of the disk."""

CORPUS: Mapping[str, Damage] = {
    **AIMED,
    **{name: damage for name, (damage, _) in REFUSED.items()},
    **{name: damage for name, (damage, _) in NEEDS_DIGEST.items()},
}
HARMLESS = (
    "lying statistics", "incremental vacuum", "free pages 4 thousand million", "first free page beyond the end",
)  # fmt: skip
"""Accepted: nothing of orient reads or believes these."""
