"""Rows of one table of one run, without reading the rest of the run: a report of a large photo must stay small."""

from collections.abc import Sequence

from orient.store.format import current_format
from orient.store.project import Project
from orient.values import Row


def read_rows(project: Project, run_id: int, table: str, columns: Sequence[str] = (), tail: str = "") -> list[Row]:
    """Rows by column in the order of the primary key, or as `tail` (WHERE goes on, ORDER BY ..., LIMIT ...) says."""
    chosen = ", ".join(f'"{name}"' for name in columns) if columns else "*"
    order = tail or "ORDER BY " + ", ".join(f'"{name}"' for name in current_format().tables[table].key)
    names, rows = project.query(f"SELECT {chosen} FROM {table} WHERE run_id = ? {order}", (run_id,))
    return [{name: value for name, value in zip(names, row, strict=True) if name != "run_id"} for row in rows]


def count_rows(project: Project, run_id: int, table: str, condition: str = "1") -> int:
    _, rows = project.query(f"SELECT count(*) FROM {table} WHERE run_id = ? AND {condition}", (run_id,))
    return int(rows[0][0])
