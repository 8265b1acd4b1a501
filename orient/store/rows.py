"""Rows into the file and out of it: one statement per table, through the driver's executemany."""

from collections.abc import Mapping, Sequence

from sqlalchemy import Connection

from orient.store.format import Format, TableShape
from orient.store.plain import StoredRows
from orient.store.stage_tables import EVENT_TABLE, STAGE_TABLES
from orient.values import Blob, Scalar


def insert_rows(connection: Connection, run_id: int, rows: StoredRows, form: Format) -> int:
    """Store the rows of a run; the number of rows."""
    for table, values in rows.items():
        names = ["run_id", *(name for name in form.tables[table].names if name != "run_id")]
        quoted = ", ".join(f'"{name}"' for name in names)
        marks = ", ".join("?" * len(names))
        statement = f"INSERT INTO {table} ({quoted}) VALUES ({marks})"
        if _has_bytes(form.tables[table]):
            for row in values:  # one part of an image in memory at a time
                connection.exec_driver_sql(statement, (run_id, *map(_fetched, row)))
        else:
            connection.exec_driver_sql(statement, [(run_id, *row) for row in values])
    return sum(len(values) for values in rows.values())


def stored_rows(connection: Connection, run_id: int, stage: str, form: Format) -> StoredRows:
    """All rows of a run, events too, in the order of the primary key; tables without rows are left out."""
    stored: StoredRows = {}
    for table in (*STAGE_TABLES.get(stage, ()), EVENT_TABLE):
        rows = _select(connection, run_id, table, form.tables[table])
        if rows:
            stored[table] = rows
    return stored


def _select(connection: Connection, run_id: int, table: str, shape: TableShape) -> list[tuple[Scalar, ...]]:
    names = ", ".join(f'"{name}"' for name in shape.names if name != "run_id")
    order = ", ".join(f'"{name}"' for name in shape.key)
    query = f"SELECT {names} FROM main.{table} WHERE run_id = ? ORDER BY {order}"
    found = connection.exec_driver_sql(query, (run_id,))
    if _has_bytes(shape):
        return [tuple(map(_told, row)) for row in found]
    return [tuple(row) for row in found.all()]


def _has_bytes(shape: TableShape) -> bool:
    return any(kind == "BLOB" for _, kind in shape.columns)


def _fetched(value: Scalar) -> Scalar | bytes:
    return value.read() if isinstance(value, Blob) and value.read is not None else value


def _told(value: Scalar | bytes) -> Scalar:
    return Blob(value) if isinstance(value, bytes) else value


def as_dicts(stored: Mapping[str, Sequence[Sequence[Scalar]]], form: Format) -> dict[str, list[dict[str, Scalar]]]:
    """Stored rows keyed by column name, events left out."""
    tables = {}
    for table, rows in stored.items():
        if table != EVENT_TABLE:
            names = [name for name in form.tables[table].names if name != "run_id"]
            tables[table] = [dict(zip(names, row, strict=True)) for row in rows]
    return tables
