"""Rows as plain numbers and words, in stored column order; the one place where NumPy scalars are cast."""

import math
from collections.abc import Iterable, Sequence

from orient.store.errors import OurFault
from orient.store.format import Format, TableShape
from orient.store.stage_tables import EVENT_TABLE, STAGE_TABLES
from orient.values import Blob, Event, Row, Scalar, Tables

REAL_LIMIT = 1e15
INTEGER_LIMIT = 2**63

StoredRows = dict[str, list[tuple[Scalar, ...]]]
"""Rows of one run by table, without `run_id`, columns in stored order."""

EVENT_FIELDS = ("severity", "code", "subject", "message", "value")


def rows_to_store(stage: str, tables: Tables, events: Sequence[Event], form: Format) -> StoredRows:
    """All rows of a run; a table or column that does not belong to the stage is our own fault."""
    for table in tables:
        if table not in STAGE_TABLES.get(stage, ()):
            raise OurFault(f'stage "{stage}" does not write table "{table}"')
    return plain_tables(tables, events, form)


def plain_tables(tables: Tables, events: Sequence[Event], form: Format) -> StoredRows:
    """Rows and events as they will be stored; tables without rows are left out."""
    everything: dict[str, Sequence[Row]] = {**tables, EVENT_TABLE: event_rows(events)}
    return {table: _plain_rows(table, rows, form.tables[table]) for table, rows in everything.items() if rows}


def event_rows(events: Iterable[Event]) -> list[Row]:
    return [
        {"seq": seq, **{name: getattr(event, name) for name in EVENT_FIELDS}} for seq, event in enumerate(events, 1)
    ]


def _plain_rows(table: str, rows: Sequence[Row], shape: TableShape) -> list[tuple[Scalar, ...]]:
    columns = [(name, kind) for name, kind in shape.columns if name != "run_id"]
    known = {name for name, _ in columns}
    plain = []
    for row in rows:
        if row.keys() != known:
            strange = sorted(row.keys() ^ known)
            raise OurFault(f'table "{table}": columns {", ".join(strange)} are missing or unknown')
        plain.append(tuple(plain_value(row[name], kind, table, name) for name, kind in columns))
    return plain


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
