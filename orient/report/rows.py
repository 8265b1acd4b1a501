"""Rows of one table of one run, without reading the rest of the run: a report of a large photo must stay small."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from orient.store.format import current_format
from orient.store.project import Project, open_project
from orient.values import Row, Scalar

PAGE = 4096


def read_rows(project: Project, run_id: int, table: str, columns: Sequence[str] = (), tail: str = "") -> list[Row]:
    """Rows by column in the order of the primary key, or as `tail` (WHERE goes on, ORDER BY ..., LIMIT ...) says."""
    chosen = ", ".join(f'"{name}"' for name in columns) if columns else "*"
    order = tail or "ORDER BY " + ", ".join(f'"{name}"' for name in current_format().tables[table].key)
    names, rows = project.query(f"SELECT {chosen} FROM {table} WHERE run_id = ? {order}", (run_id,))
    return [{name: value for name, value in zip(names, row, strict=True) if name != "run_id"} for row in rows]


@dataclass(frozen=True)
class PagedRows:
    """Rows of runs, read a page at a time whenever they are gone through: memory does not grow with their number.

    `sql` asks for the rows behind the key :after in the order of the key, which is their first column. Runs never
    change, so that pages read one after the other belong together.
    """

    path: Path
    sql: str
    parameters: Mapping[str, Scalar]

    def __iter__(self) -> Iterator[Sequence[Scalar]]:
        with open_project(self.path, "read") as project:
            after: Scalar = ""
            while True:
                sql = f"{self.sql} LIMIT {PAGE}"
                _, rows = project.query(sql, {**self.parameters, "after": after}, timeout_s=None)
                yield from rows
                if len(rows) < PAGE:
                    return
                after = rows[-1][0]
                del rows  # before the next page comes


def count_rows(project: Project, run_id: int, table: str, condition: str = "1") -> int:
    _, rows = project.query(f"SELECT count(*) FROM {table} WHERE run_id = ? AND {condition}", (run_id,))
    return int(rows[0][0])
