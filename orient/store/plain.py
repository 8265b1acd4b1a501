"""Rows as plain numbers and words, by column, in the order of the key; the one place where NumPy scalars are cast."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from operator import le
from types import NoneType
from typing import Any

from orient.store.errors import OurFault
from orient.store.format import Format, TableShape
from orient.store.stage_tables import EVENT_TABLE, STAGE_TABLES
from orient.values import Blob, Columns, Event, Row, Scalar, Tables, as_list

REAL_LIMIT = 1e15
INTEGER_LIMIT = 2**63
CHUNK = 512
"""Rows that are handled at once: fewer than the 700 new objects at which Python's collector looks through them."""

EVENT_FIELDS = ("severity", "code", "subject", "message", "value")


@dataclass(frozen=True)
class PlainTable:
    """Rows of one table of a run as they will be stored, in the order of the primary key.

    `columns`: of each name of the table but `run_id`, in stored order; lists or arrays.
    """

    names: tuple[str, ...]
    columns: Sequence[Any]

    def __len__(self) -> int:
        return len(self.columns[0])

    @cached_property
    def used(self) -> list[str]:
        """Columns with any value."""
        return [name for name, values in zip(self.names, self.columns, strict=True) if _has_values(values)]

    def rows(self) -> Columns:
        return Columns(dict(zip(self.names, self.columns, strict=True)))

    def chunks(self) -> Iterator[list[tuple[Scalar, ...]]]:
        """All rows, some hundred at a time."""
        for columns in self.column_chunks():
            yield list(zip(*columns, strict=True))

    def column_chunks(self) -> Iterator[list[Sequence[Scalar]]]:
        """The same by column."""
        for begin in range(0, len(self), CHUNK):
            yield [as_list(values[begin : begin + CHUNK]) for values in self.columns]


def _has_values(values: Any) -> bool:
    if hasattr(values, "compressed"):  # a masked array
        return bool(values.count())
    return hasattr(values, "tolist") or values.count(None) < len(values)


def plain_tables(tables: Tables, events: Sequence[Event], form: Format) -> dict[str, PlainTable]:
    """Rows and events as they will be stored; tables without rows are left out."""
    everything: dict[str, Sequence[Row]] = {**tables, EVENT_TABLE: event_rows(events)}
    return {table: _plain_table(table, rows, form.tables[table]) for table, rows in everything.items() if rows}


def require_own_tables(stage: str, tables: Iterable[str]) -> None:
    """A table that does not belong to the stage is our own fault."""
    for table in tables:
        if table not in (*STAGE_TABLES.get(stage, ()), EVENT_TABLE):
            raise OurFault(f'stage "{stage}" does not write table "{table}"')


def event_rows(events: Iterable[Event]) -> list[Row]:
    return [
        {"seq": seq, **{name: getattr(event, name) for name in EVENT_FIELDS}} for seq, event in enumerate(events, 1)
    ]


def _plain_table(table: str, rows: Sequence[Row], shape: TableShape) -> PlainTable:
    kinds = {name: kind for name, kind in shape.columns if name != "run_id"}
    given = rows.by_name if isinstance(rows, Columns) else _by_column(table, rows, list(kinds))
    _require_names(table, given.keys(), kinds.keys())
    plain = {name: plain_column(given[name], kind, table, name) for name, kind in kinds.items()}
    key = [plain[name] for name in shape.key if name != "run_id"]
    return PlainTable(tuple(kinds), _in_order(list(plain.values()), key))


def _by_column(table: str, rows: Sequence[Row], names: Sequence[str]) -> dict[str, list[Scalar]]:
    for row in rows:
        if len(row) != len(names):
            _require_names(table, row.keys(), names)
    try:
        return {name: [row[name] for row in rows] for name in names}
    except KeyError:
        for row in rows:
            _require_names(table, row.keys(), names)
        raise


def _require_names(table: str, given: Iterable[str], known: Iterable[str]) -> None:
    if strange := sorted(set(given) ^ set(known)):
        raise OurFault(f'table "{table}": columns {", ".join(strange)} are missing or unknown')


def _in_order(columns: list[Any], key: Sequence[Any]) -> list[Any]:
    """The columns with their rows sorted by the columns of the key."""
    if not key:
        return columns
    lists: list[Sequence[Any]] = [as_list(values) for values in key]
    if all(map(le, zip(*lists, strict=True), islice(zip(*lists, strict=True), 1, None))):
        return columns
    order = list(range(len(lists[0])))
    for values in reversed(lists):  # a stable sort by the last column first needs no tuple for each row
        order.sort(key=values.__getitem__)
    return list(Columns(dict(enumerate(columns))).at(order).by_name.values())  # type: ignore[arg-type]


def plain_column(values: Any, kind: str, table: str, column: str) -> Any:
    """A column as `plain_value` makes it; columns of one type are looked at as a whole."""
    if hasattr(values, "compressed") and not values.mask.any():
        values = values.data  # a masked array in which all is known
    if kind == "REAL" and str(getattr(values, "dtype", "")) == "float64":
        known = values.compressed() if hasattr(values, "compressed") else values
        if abs(known).max(initial=0.0) <= REAL_LIMIT:  # false for NaN
            return values + 0.0
        return [plain_value(value, kind, table, column) for value in values.tolist()]
    values = as_list(values)
    types = set(map(type, values))
    if types == {NoneType} or (kind == "TEXT" and types == {str}):
        return values
    if kind == "INTEGER" and types == {int} and min(values) >= -INTEGER_LIMIT and max(values) < INTEGER_LIMIT:
        return values
    if kind == "REAL" and types == {float} and _are_storable(values):
        return [value + 0.0 for value in values]
    return [plain_value(value, kind, table, column) for value in values]


def _are_storable(numbers: Sequence[float]) -> bool:
    return math.isfinite(sum(numbers)) and max(numbers) <= REAL_LIMIT and min(numbers) >= -REAL_LIMIT


def plain_value(value: object, kind: str, table: str, column: str) -> Scalar:
    """The value as column type `kind` stores it: str, int, float, Blob or None. NaN, infinity, others are refused."""
    item = value.item() if hasattr(value, "item") else value
    if isinstance(item, Blob) and kind == "BLOB":
        return item
    if item is None or (kind == "TEXT" and isinstance(item, str)):
        return None if item is None else str(item)
    if kind == "REAL" and isinstance(item, int | float):
        number = float(item) + 0.0  # -0.0 becomes 0.0, so that equal numbers have equal digests
        if math.isfinite(number) and abs(number) <= REAL_LIMIT:
            return number
    if kind == "INTEGER" and isinstance(item, int) and -INTEGER_LIMIT <= item < INTEGER_LIMIT:
        return int(item)
    raise OurFault(f'table "{table}", column "{column}": {str(value)[:60]!r} cannot be stored as {kind}')
