"""Promises V2 to V7 (RELIABILITY.md 3.2): an upgrade loses nothing, shows nothing half, runs nothing of a stranger."""

import gzip
import hashlib
import os
import shutil
import sqlite3
import subprocess
import sys
import threading
import time
from contextlib import closing
from pathlib import Path

import pytest

from orient.errors import ProjectError
from orient.models import SCHEMA_VERSION
from orient.store import upgrade
from orient.store.check import check_project
from orient.store.errors import Replaced, StorageError
from orient.store.project import open_project
from orient.store.upgrade import upgrade_project
from tests.cli.commands import orient, start
from tests.promises import Promise
from tests.store.test_opening import Damage, sql, unguarded

DATA = Path(__file__).parents[1] / "data"
PACKED = sorted(DATA.glob("format-*/*.sqlite.gz"))
VERSION_AT = slice(60, 64)


def unpacked(packed: Path, folder: Path) -> Path:
    path = folder / "photo.sqlite"
    path.write_bytes(gzip.decompress(packed.read_bytes()))
    return path


@pytest.fixture
def old(tmp_path: Path) -> Path:
    return unpacked(PACKED[0], tmp_path)


def sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def names(path: Path) -> list[str]:
    return sorted(entry.name for entry in path.parent.iterdir())


def rows(path: Path) -> dict[str, int]:
    with closing(sqlite3.connect(path)) as bare:
        tables = [name for (name,) in bare.execute("SELECT name FROM sqlite_schema WHERE type = 'table'")]
        return {name: bare.execute(f'SELECT count(*) FROM "{name}"').fetchone()[0] for name in tables}


def schema(path: Path) -> list[tuple[object, ...]]:
    with closing(sqlite3.connect(path)) as bare:
        return bare.execute("SELECT type, name, tbl_name, sql FROM sqlite_schema ORDER BY 1, 2").fetchall()


@pytest.mark.parametrize("packed", PACKED, ids=lambda path: f"{path.parent.name} {path.name.split('.')[0]}")
def test_V3_schema_of_a_new_file_and_all_rows(packed: Path, tmp_path: Path, full: Path, promise: Promise) -> None:
    folder = tmp_path / "old"
    folder.mkdir()
    path = unpacked(packed, folder)
    before, content = rows(path), path.read_bytes()
    with promise("V3").trial(packed.name):
        said = orient("upgrade", path)
        assert said.code == 0, said.err
        after = rows(path)
        assert {name: after[name] for name in before} == before
        assert schema(path) == schema(full)
        assert check_project(path).ok
    with promise("V5").trial(packed.name):
        (kept,) = folder.glob("photo.sqlite.bak-*")
        assert kept.read_bytes() == content


STRANGE: dict[str, tuple[Damage, str]] = {
    "table": (sql("CREATE TABLE extra (a)"), "never makes: table 'extra'"),
    "virtual table": (sql("CREATE VIRTUAL TABLE extra USING fts5 (a)"), "never makes: table 'extra'"),
    "generated column": (
        sql("ALTER TABLE photo ADD COLUMN big TEXT GENERATED ALWAYS AS (hex(zeroblob(400000000))) VIRTUAL"),
        "differs in table 'photo'",
    ),
    "index": (sql("CREATE INDEX extra ON photo (hex(name))"), "never makes: index 'extra'"),
    "missing table": (sql("DROP TABLE model_point"), "missing: index 'sqlite_autoindex_model_point_1'"),
    "changed row": (unguarded("UPDATE stage_run SET reason = 'other' WHERE run_id = 3"), "does not keep the results"),
    "revision": (unguarded("UPDATE alembic_version SET version_num = 'x'"), "an upgrade was not finished"),
}


@pytest.mark.parametrize("name", STRANGE)
def test_a_strangers_old_file_is_refused_unread(name: str, old: Path, promise: Promise) -> None:
    damage, words = STRANGE[name]
    damage(old)
    before = sha256(old)
    for kept in (promise("S4"), promise("V2")):
        with kept.trial(f"old file, {name}"):
            said = orient("upgrade", old)
            assert said.code == 3, said.out + said.err
            assert words in said.err, said.err
            assert "Traceback" not in said.err
            assert sha256(old) == before
            assert names(old) == [old.name]


def test_a_strangers_trigger_and_view_do_not_come_along(old: Path, full: Path, promise: Promise) -> None:
    sql(
        "CREATE TRIGGER t AFTER INSERT ON stage_run BEGIN DELETE FROM run_event; END",
        "CREATE VIEW extra AS SELECT load_extension('x')",
    )(old)
    before = rows(old)
    with promise("S4").trial("trigger and view of an old file"):
        assert orient("upgrade", old).code == 0
        assert schema(old) == schema(full)
        assert rows(old)["run_event"] == before["run_event"]


READ_FOR_EVER = """
import sqlite3, sys
while True:
    base = sqlite3.connect(f"file:{sys.argv[1]}?mode=ro", uri=True)
    version = base.execute("PRAGMA user_version").fetchone()[0]
    is_new = base.execute("SELECT count(*) FROM sqlite_schema WHERE name = 'sealed_run'").fetchone()[0]
    base.close()
    print(version, is_new, flush=True)
"""


def test_V4_a_reader_sees_the_old_or_the_new_file(old: Path, promise: Promise) -> None:
    """Format and tables belong together at every moment."""
    seen: set[tuple[int, int]] = set()
    reader = subprocess.Popen([sys.executable, "-c", READ_FOR_EVER, str(old)], stdout=subprocess.PIPE, text=True)

    def listen() -> None:
        assert reader.stdout is not None
        for line in reader.stdout:
            if line.endswith("\n"):  # the last one may be cut
                version, is_new = map(int, line.split())
                seen.add((version, is_new))

    listener = threading.Thread(target=listen)
    listener.start()
    try:
        _wait(lambda: bool(seen))
        assert orient("upgrade", old).code == 0
        _wait(lambda: len(seen) > 1)
    finally:
        reader.kill()
        listener.join(10)
        reader.wait()
    with promise("V4").trial("a reader meanwhile"):
        assert seen == {(1, 0), (SCHEMA_VERSION, 1)}


def _wait(until: object) -> None:
    give_up = time.monotonic() + 30
    while not until() and time.monotonic() < give_up:  # type: ignore[operator]
        time.sleep(0.02)


@pytest.mark.parametrize("is_good", [True, False], ids=["a good copy", "a bad copy"])
def test_V5_a_backup_where_a_file_has_one_name_only(
    is_good: bool, old: Path, monkeypatch: pytest.MonkeyPatch, promise: Promise
) -> None:
    """No hard links: the backup is a copy; one that is not the same stops the upgrade."""

    def no_link(*_: object, **__: object) -> None:
        raise PermissionError(1, "no hard links here")

    def spoiled(source: Path, target: Path) -> None:
        real(source, target)
        if copies and not is_good:
            with target.open("r+b") as file:
                file.seek(5000)
                file.write(b"x")
        copies.append(target)

    copies: list[Path] = []
    real = upgrade.copy_pages
    monkeypatch.setattr(os, "link", no_link)
    monkeypatch.setattr(upgrade, "copy_pages", spoiled)
    before = sha256(old)
    with promise("V5").trial("no hard links"):
        if is_good:
            done = upgrade_project(old)
            assert done.backup is not None
            with closing(sqlite3.connect(done.backup)) as bare:
                assert bare.execute("PRAGMA integrity_check").fetchone() == ("ok",)
                assert bare.execute("PRAGMA user_version").fetchone() == (1,)
            assert check_project(old).ok
        else:
            with pytest.raises(StorageError, match="is not what was read"):
                upgrade_project(old)
            assert sha256(old) == before
            assert names(old) == [old.name]


def test_V6_a_newer_file_names_the_way_back(full: Path, promise: Promise) -> None:
    content = bytearray(full.read_bytes())
    content[VERSION_AT] = (SCHEMA_VERSION + 1).to_bytes(4, "big")
    full.write_bytes(content)
    with promise("V6").trial("without a backup"), pytest.raises(ProjectError, match="newer orient") as error:
        open_project(full)
    assert error.value.hint == "Upgrade orient."
    backup = full.with_name(f"{full.name}.bak-{SCHEMA_VERSION:04d}")
    shutil.copy(full, backup)
    with promise("V6").trial("with a backup"), pytest.raises(ProjectError, match="newer orient") as error:
        open_project(full)
    assert backup.name in error.value.hint
    with promise("V6").trial("upgrade"), pytest.raises(ProjectError, match="newer orient"):
        upgrade_project(full)


def test_hard_links_and_owner_are_told(old: Path, promise: Promise) -> None:
    second = old.with_name("second")
    os.link(old, second)
    before = sha256(second)
    is_root = os.geteuid() == 0
    if is_root:
        os.chown(old, 12345, -1)
    with promise("V2").trial("hard link"):
        said = orient("upgrade", old)
        assert said.code == 0, said.err
        assert "has 2 names (hard links); an upgrade or a copy separates them" in said.out
        assert ("belonged to another user (number 12345)" in said.out) == is_root
        assert sha256(second) == before


def test_a_symbolic_link_stays_one(old: Path, promise: Promise) -> None:
    link = old.with_name("link")
    link.symlink_to(old.name)
    with promise("V2").trial("symbolic link"):
        assert orient("upgrade", link).code == 0
        assert link.is_symlink()
        assert check_project(old).ok
        assert (old.parent / f"{old.name}.bak-0001").exists()


WRITE_LATE = """
import sqlite3, sys
base = sqlite3.connect(sys.argv[1], isolation_level=None, timeout=0)
base.execute("SELECT count(*) FROM photo").fetchone()
print("open", flush=True)
sys.stdin.readline()
try:
    base.execute("BEGIN IMMEDIATE")
    base.execute("INSERT INTO selection SELECT 999, stage, run_id, '', '', '', 1, '' FROM selection LIMIT 1")
    base.execute("COMMIT")
    print("written")
except sqlite3.Error as error:
    print(error.sqlite_errorname)
"""


def test_V7_another_program_with_the_file_open_cannot_write_into_the_new_one(old: Path, promise: Promise) -> None:
    other = subprocess.Popen(
        [sys.executable, "-c", WRITE_LATE, str(old)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert other.stdout is not None
    assert other.stdout.readline() == "open\n"
    with promise("V7").trial("another program"):
        assert orient("upgrade", old).code == 0
        after = sha256(old)
        out, _ = other.communicate("now\n")
        assert out == "SQLITE_READONLY_DBMOVED\n"
        assert sha256(old) == after
        assert check_project(old).ok


def test_V7_of_two_upgrades_at_once_one_does_it(old: Path, promise: Promise) -> None:
    before = sha256(old)
    with promise("V7").trial("two upgrades"):
        children = [start("upgrade", old) for _ in range(2)]
        ended = [(child.communicate(timeout=120), child.returncode) for child in children]
        codes = sorted(code for _, code in ended)
        texts = b" ".join(out + err for (out, err), _ in ended)
        assert codes in ([0, 0], [0, 3]), texts
        assert codes == [0, 0] or b"was replaced" in texts
        assert check_project(old).ok
        (backup,) = old.parent.glob("photo.sqlite.bak-*")
        assert sha256(backup) == before
        assert names(old) == [old.name, backup.name]


def test_V7_an_upgrade_that_waited_finds_another_file(
    old: Path, monkeypatch: pytest.MonkeyPatch, promise: Promise
) -> None:
    """Another file takes the name after the look at it, before the lock."""

    def replaced_meanwhile(path: Path, *words: object) -> object:
        shutil.copy(path, other)
        other.replace(path)
        monkeypatch.setattr(upgrade, "open_engine", real)
        return real(path, *words)  # type: ignore[arg-type]

    real, other = upgrade.open_engine, old.with_name("other")
    monkeypatch.setattr(upgrade, "open_engine", replaced_meanwhile)
    with promise("V7").trial("replaced"), pytest.raises(Replaced):
        upgrade_project(old)
    assert names(old) == [old.name]
