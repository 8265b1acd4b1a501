"""Damages of a project file at random places, and its content read without orient."""

import random
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from orient.store.format import current_format

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
    first, second, size = page_start(content, chance), page_start(content, chance), page_size(content)
    one, other = content[first : first + size], content[second : second + size]
    content[first : first + size], content[second : second + size] = other, one


def zero(content: bytearray, chance: Random) -> None:
    start, size = page_start(content, chance), page_size(content)
    content[start : start + size] = bytes(size)


def duplicate(content: bytearray, chance: Random) -> None:
    start, size = page_start(content, chance), page_size(content)
    content[start : start + size] = content[:size] if chance.random() < 0.1 else content[-size:]


def grow(content: bytearray, chance: Random) -> None:
    content += chance.randbytes(chance.randrange(1, 3 * page_size(content)))


def text_byte(content: bytearray, chance: Random) -> None:
    """A byte in the rows, where SQLite's own checks see nothing."""
    place = content.find(b"made", chance.randrange(len(content) // 2))
    place = content.index(b"made") if place < 0 else place
    content[place - chance.randrange(40)] = chance.randrange(256)


def page_size(content: bytearray) -> int:
    return int.from_bytes(content[16:18], "big")


def page_start(content: bytearray, chance: Random) -> int:
    size = page_size(content)
    return size * chance.randrange(1, len(content) // size)


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
