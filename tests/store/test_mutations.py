"""300 damaged files: none crashes, none hangs, none passes `orient check` with other content than was stored."""

import random
import sqlite3
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from orient.store.check import check_project
from orient.store.format import current_format

PAGE = 4096
Random = random.Random


def one_byte(content: bytearray, chance: Random) -> None:
    content[chance.randrange(len(content))] = chance.randrange(256)


def header_byte(content: bytearray, chance: Random) -> None:
    content[chance.randrange(100)] = chance.randrange(256)


def page_header(content: bytearray, chance: Random) -> None:
    content[page_start(content, chance) + chance.randrange(12)] = chance.randrange(256)


def cell_pointer(content: bytearray, chance: Random) -> None:
    content[page_start(content, chance) + 8 + chance.randrange(60)] = chance.randrange(256)


def truncate(content: bytearray, chance: Random) -> None:
    del content[chance.randrange(100, len(content)) :]


def swap(content: bytearray, chance: Random) -> None:
    first, second = page_start(content, chance), page_start(content, chance)
    one, other = content[first : first + PAGE], content[second : second + PAGE]
    content[first : first + PAGE], content[second : second + PAGE] = other, one


def zero(content: bytearray, chance: Random) -> None:
    start = page_start(content, chance)
    content[start : start + PAGE] = bytes(PAGE)


def duplicate(content: bytearray, chance: Random) -> None:
    start = page_start(content, chance)
    content[start : start + PAGE] = content[:PAGE] if chance.random() < 0.1 else content[-PAGE:]


def grow(content: bytearray, chance: Random) -> None:
    content += chance.randbytes(chance.randrange(1, 3 * PAGE))


def text_byte(content: bytearray, chance: Random) -> None:
    """A byte in the rows, where SQLite's own checks see nothing."""
    place = content.find(b"made", chance.randrange(len(content) // 2))
    place = content.index(b"made") if place < 0 else place
    content[place - chance.randrange(40)] = chance.randrange(256)


def page_start(content: bytearray, chance: Random) -> int:
    return PAGE * chance.randrange(1, len(content) // PAGE)


KINDS: tuple[Callable[[bytearray, Random], None], ...] = (
    one_byte, one_byte, header_byte, page_header, cell_pointer, truncate, swap, zero, duplicate, grow, text_byte,
    text_byte,
)  # fmt: skip


def content_of(path: Path) -> object:
    """All rows of all tables, read without orient; None if they cannot be read."""
    try:
        with closing(sqlite3.connect(f"{path.as_uri()}?mode=ro", uri=True)) as bare:
            bare.text_factory = bytes
            bare.execute("PRAGMA trusted_schema = OFF")
            return {name: sorted(bare.execute(f"SELECT * FROM {name}"), key=repr) for name in current_format().tables}
    except (sqlite3.Error, UnicodeError, OverflowError):
        return None


def test_no_damage_passes_unseen(full: Path, tmp_path: Path) -> None:
    original = full.read_bytes()
    meant = content_of(full)
    chance = random.Random(300)
    path = tmp_path / "damaged.orient"
    found = harmless = 0
    for number in range(300):
        content = bytearray(original)
        kind = KINDS[number % len(KINDS)]
        kind(content, chance)
        path.write_bytes(content)
        started = time.monotonic()
        ok = check_project(path).ok
        assert time.monotonic() - started < 3
        assert not ok or content_of(path) == meant, f"{kind.__name__}, number {number}"
        found, harmless = found + (not ok), harmless + ok
    assert found > 150
    assert harmless > 10
