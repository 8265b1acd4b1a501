"""Rows into the file and out of it: one statement per table, straight through the driver, some rows at a time."""

import sqlite3
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain
from typing import Any

from sqlalchemy import Connection

from orient.store.connection import driver_of, room_to_append
from orient.store.format import Format, TableShape
from orient.store.plain import CHUNK, PlainTable
from orient.store.stage_tables import EVENT_TABLE, STAGE_TABLES
from orient.values import Blob, Columns, Scalar

Rows = list[tuple[Scalar, ...]]
TOGETHER = 32
"""Rows of one statement: they are stored in two thirds of the time that so many statements of one row take."""


def insert_rows(connection: Connection, run_id: int, tables: Mapping[str, PlainTable], form: Format) -> int:
    """Store the rows of a run; the number of rows."""
    driver = driver_of(connection)
    with room_to_append(connection):
        for table, rows in tables.items():
            if form.tables[table].has_bytes:  # fetched as they are stored: one part of an image in memory at a time
                statement = _insertion(run_id, table, rows.names, 1)
                values = (tuple(map(_fetched, row)) for some in rows.chunks() for row in some)
                driver.executemany(statement, values)
            else:
                _insert_by_column(driver, run_id, table, rows)
    return sum(map(len, tables.values()))


def _insert_by_column(driver: sqlite3.Connection, run_id: int, table: str, rows: PlainTable) -> None:
    """Some rows by one statement, the last ones one by one; columns without values are not named."""
    used = rows.used or rows.names  # a row may have no value at all
    places = [rows.names.index(name) for name in used]
    for columns in rows.column_chunks():
        some = [columns[place] for place in places]
        whole = len(some[0]) - len(some[0]) % TOGETHER
        if whole:
            row = zip(*(column[:whole] for column in some), strict=True)
            one_after_the_other = chain.from_iterable(row)
            values = zip(*[one_after_the_other] * (TOGETHER * len(some)), strict=True)  # as many for each statement
            driver.executemany(_insertion(run_id, table, used, TOGETHER), values)
        driver.executemany(_insertion(run_id, table, used, 1), zip(*(column[whole:] for column in some), strict=True))


def _insertion(run_id: int, table: str, names: Sequence[str], number: int) -> str:
    """The statement for some rows; marks with numbers would make it slow to prepare."""
    columns = ", ".join(f'"{name}"' for name in ("run_id", *names))
    row = f"({int(run_id)}{', ?' * len(names)})"
    return f"INSERT INTO {table} ({columns}) VALUES {', '.join([row] * number)}"


@dataclass(frozen=True)
class StoredTable:
    """Rows of one table of a run in the file, in the order of the primary key; read when they are asked for.

    `seen` is told how many rows have been read.
    """

    driver: sqlite3.Connection
    run_id: int
    table: str
    shape: TableShape
    seen: Callable[[int], None] = field(default=lambda rows: None)

    @property
    def names(self) -> tuple[str, ...]:
        return self.shape.own

    @cached_property
    def _counts(self) -> tuple[int, ...]:
        """Number of rows, then of values in each column."""
        counts = ", ".join(f'count("{name}")' for name in self.names)
        query = f"SELECT count(*), {counts} FROM main.{self.table} WHERE run_id = ?"
        return tuple(self.driver.execute(query, (self.run_id,)).fetchone())

    def __len__(self) -> int:
        return self._counts[0]

    @property
    def used(self) -> list[str]:
        """Columns with any value."""
        return [name for name, count in zip(self.names, self._counts[1:], strict=True) if count]

    def chunks(self) -> Iterator[Rows]:
        """All rows, some hundred at a time."""
        names = ", ".join(f'"{name}"' for name in self.names)
        order = ", ".join(f'"{name}"' for name in self.shape.key)
        query = f"SELECT {names} FROM main.{self.table} WHERE run_id = ? ORDER BY {order}"
        cursor = self.driver.execute(query, (self.run_id,))
        if self.shape.has_bytes:
            for row in cursor:
                self.seen(1)
                yield [tuple(map(_told, row))]
            return
        while rows := cursor.fetchmany(CHUNK):
            self.seen(len(rows))
            yield rows

    def column_chunks(self) -> Iterator[list[Sequence[Scalar]]]:
        """The same by column."""
        for rows in self.chunks():
            yield list(zip(*rows, strict=True))

    def dicts(self) -> list[dict[str, Scalar]]:
        return [dict(zip(self.names, row, strict=True)) for rows in self.chunks() for row in rows]

    def columns(self) -> Columns:
        """The same by column: numbers that are all known as an array; a word that repeats is kept once in a chunk."""
        kinds = dict(self.shape.columns)
        columns: list[Any] = [array("d") if kinds[name] == "REAL" else [] for name in self.names]
        are_words = [kinds[name] == "TEXT" for name in self.names]
        for rows in self.chunks():
            columns = list(map(_extended, columns, zip(*rows, strict=True), are_words))
        return Columns(dict(zip(self.names, columns, strict=True)))


def stored_tables(
    connection: Connection, run_id: int, stage: str, form: Format, seen: Callable[[int], None] = lambda rows: None
) -> dict[str, StoredTable]:
    """All tables that a run of this stage may have rows in, the events too."""
    driver = driver_of(connection)
    names = (*STAGE_TABLES.get(stage, ()), EVENT_TABLE)
    return {name: StoredTable(driver, run_id, name, form.tables[name], seen) for name in names}


def _extended(values: Any, some: Sequence[Any], are_words: bool) -> Any:
    """The column with some values more: an array while all its numbers are known, a list from the first NULL on."""
    if isinstance(values, array):
        try:
            values.extend(array("d", some))
        except TypeError:
            values = values.tolist()
        else:
            return values
    values.extend(map({}.setdefault, some, some) if are_words else some)
    return values


def _fetched(value: Scalar) -> Scalar | bytes:
    return value.read() if isinstance(value, Blob) and value.read is not None else value


def _told(value: Scalar | bytes) -> Scalar:
    return Blob(value) if isinstance(value, bytes) else value
