"""D: the project file. What a stranger, an accident or another program can do to it, and what `status` and `check` say.

The damages are those of tests/store/test_opening.py, which opens the files without the command line.
"""

import gzip
import os
from collections.abc import Callable, Mapping
from pathlib import Path

from orient.store.project import open_project
from tests.catalogue.case import PROJECT, Case, Place
from tests.cli.commands import ROOT
from tests.store.made import new_run
from tests.store.test_opening import (
    ACCEPTED,
    INFINITY,
    NEEDS_DIGEST,
    REFUSED,
    Damage,
    leave_hot_journal,
    sql,
    unguarded,
    wal_mode,
)

OLD = ROOT / "tests" / "data" / "format-1" / "calgary-27.sqlite.gz"
STATUS, CHECK = ("status", PROJECT), ("check", PROJECT)


def damaged(damage: Damage) -> Callable[[Place], None]:
    def before(place: Place) -> None:
        damage(place.take_full())

    return before


def opened(damage: Damage, matches: str, code: int = 3) -> Case:
    """`status` refuses, and nothing is made, removed or changed."""
    return Case(words=STATUS, code=code, matches=matches, before=damaged(damage))


def checked(damage: Damage, matches: str) -> Case:
    """It opens; `check` finds it."""
    return Case(words=CHECK, code=3, matches=f"FAULT .*({matches})", before=damaged(damage))


def healthy(damage: Damage, *says: str, changes: bool = False) -> Case:
    return Case(words=STATUS, code=0, says=says, before=damaged(damage), changes=changes)


def old_format(path: Path) -> None:
    path.write_bytes(gzip.decompress(OLD.read_bytes()))


def flipped(place: Place) -> None:
    """One bit of a stored name, where SQLite itself sees nothing."""
    content = bytearray(place.take_full().read_bytes())
    content[content.index(b"image_file")] ^= 1
    place.project.write_bytes(content)


def hot_journal(place: Place) -> None:
    other = place.root / "other"
    other.mkdir()
    place.take_full().rename(other / place.project.name)
    leave_hot_journal(other / place.project.name, place.root)
    for path in other.iterdir():
        path.unlink()
    other.rmdir()


def alone(place: Place) -> None:
    """The journal is gone, and so is what it undid."""
    assert not Path(f"{place.project}-journal").exists()
    assert place.say(CHECK).code == 0


def no_strict(statement: str) -> Damage:
    """A row that STRICT forbids, in a file whose schema text says STRICT as before."""
    strip = "UPDATE sqlite_schema SET sql = replace(sql, 'STRICT', '') WHERE name = 'image_point'"
    put_back = "UPDATE sqlite_schema SET sql = sql || 'STRICT' WHERE name = 'image_point'"

    def damage(path: Path) -> None:
        sql("PRAGMA writable_schema = ON", strip)(path)
        unguarded(UNCHECKED, statement)(path)
        sql("PRAGMA writable_schema = ON", put_back)(path)

    return damage


def settings(text: str) -> Damage:
    return unguarded(f"UPDATE stage_run SET settings = {text} WHERE run_id = 7")


def many_tables(path: Path) -> None:
    """80 MB of them need minutes to make; what is refused is their number, before any is looked at."""
    numbers = "WITH RECURSIVE r(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM r WHERE n < 20000)"
    root = "(SELECT rootpage FROM sqlite_schema WHERE name = 'photo')"
    added = f"{numbers} SELECT 'table', 't' || n, 't' || n, {root}, 'CREATE TABLE t' || n || ' (a)' FROM r"
    sql("PRAGMA writable_schema = ON", f"INSERT INTO sqlite_schema {added}")(path)


def image_part(content: str) -> Damage:
    """Bytes in the only column that holds bytes, in a run that may write there."""

    def damage(path: Path) -> None:
        with open_project(path, "write") as project:
            project.append(new_run(project, "image"))
        unguarded(UNCHECKED, f"UPDATE image_part SET content = {content}")(path)

    return damage


UNCHECKED = "PRAGMA ignore_check_constraints = ON"
ANSWERS: Mapping[str, Case] = {
    "D6": opened(old_format, "has format 1[.]\\n +Run: orient upgrade .*keeps a backup"),
    "D11": healthy(lambda path: os.link(path, path.with_name("second")), "has 2 names (hard links)"),
    "D13": Case(words=CHECK, code=3, matches="FAULT .*rows were altered after the seal", before=flipped),
    "D16 receive": Case(
        words=("receive", PROJECT, f"{PROJECT}.copy"),
        code=0,
        says=["clean copy"],
        changes=True,
        before=damaged(wal_mode),
    ),
    "D18": Case(
        words=STATUS,
        code=0,
        says=["was recovered from an interrupted command"],
        before=hot_journal,
        changes=True,
        then=alone,
    ),
    "D27": checked(image_part("zeroblob(70000000)"), "run 13: cannot be read .string or blob too big"),
    "D27 another size": checked(image_part("zeroblob(1048577)"), "run 13 .image.: rows were altered"),
    "D28 infinity": checked(INFINITY, "run 5 .model.: rows were altered"),
    "D28 text": opened(no_strict("UPDATE image_point SET x_mm = 'ten'"), "damaged .*image_point"),
    "D29 not a number": checked(settings("""'{"a": NaN}'"""), "run 7"),
    "D29 a key twice": checked(settings("""'{"seed": 0.5, "seed": 0.25}'"""), "run 7"),
    "D29 large": checked(settings("""printf('{"a": "%.*c"}', 50000000, 'x')"""), "settings of run 7 are not valid"),
    "D30 NUL": checked(unguarded("UPDATE photo SET name = 'a' || char(0) || 'b'"), "run 1"),
    "D30 surrogate": checked(unguarded("UPDATE photo SET name = CAST(x'eda080' AS TEXT)"), "run 1: text is not UTF-8"),
    "D40": opened(many_tables, "never makes: 20[0-9]{3} tables, views"),
}


def _told(name: str, words: str) -> Case:
    """The store's tests call the project house.orient."""
    words = words.replace("house.orient", "photo.sqlite")
    return opened(REFUSED[name][0], words, 2 if "no such project" in words else 3)


CASES: dict[str, Case] = {
    **{name: _told(name, words) for name, (_, words) in REFUSED.items()},
    **{name: checked(*row) for name, row in NEEDS_DIGEST.items()},
    **{name: healthy(damage, changes="journal" in name) for name, damage in ACCEPTED.items()},
    **ANSWERS,
}
