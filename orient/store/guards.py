"""Guards and views: written into every project. The gate compares them byte by byte before they may run."""

from collections.abc import Iterable
from functools import cache
from pathlib import Path

from sqlalchemy import Connection

from orient.store.format import Format

GUARDS_FILE = Path(__file__).with_name("guards.sql")
VIEWS_FILE = Path(__file__).with_name("views.sql")
SEAL_EXEMPT = frozenset({"selection", "alembic_version"})
"""A selection comes after the seal; `alembic_version` has no run."""

CTE_NAMES = frozenset(
    {
        "stale", "along", "part", "by_source", "share", "answer", "ranked", "median", "influence", "given", "told",
        "pair", "side", "rests", "computed", "used", "ranked_image", "ranked_ground",
    }
)  # fmt: skip
"""Names of WITH clauses in views.sql; the authorizer lets them through."""


@cache
def _statements(file: Path) -> tuple[str, ...]:
    blocks = file.read_text(encoding="utf-8").split(";\n\n")
    bare = ("\n".join(line for line in block.splitlines() if not line.startswith("--")) for block in blocks)
    return tuple(text for text in (block.strip().removesuffix(";") for block in bare) if text)


def view_statements() -> tuple[str, ...]:
    return _statements(VIEWS_FILE)


def guard_statements(tables: Iterable[str]) -> list[str]:
    """Every trigger for these tables, in a fixed order."""
    names = sorted(tables)
    statements: list[str] = []
    for template in _statements(GUARDS_FILE):
        if "{table}" in template:
            statements += [template.replace("{table}", name) for name in names]
        elif "{run_table}" in template:
            statements += [template.replace("{run_table}", name) for name in names if name not in SEAL_EXEMPT]
        else:
            statements.append(template)
    return statements


def store_copies(connection: Connection, tables: Iterable[str]) -> None:
    """Write guards and views into the file (a new file, or one that is being upgraded)."""
    for statement in (*view_statements(), *guard_statements(tables)):
        connection.exec_driver_sql(statement)


def drop_copies(connection: Connection) -> None:
    rows = connection.exec_driver_sql("SELECT type, name FROM main.sqlite_schema WHERE type IN ('view', 'trigger')")
    for kind, name in rows.all():
        connection.exec_driver_sql(f"DROP {kind} main.{quoted(name)}")


def quoted(name: str) -> str:
    """An SQL name that cannot end early, whatever a stranger wrote into it."""
    return '"' + name.replace('"', '""') + '"'


def own_names(form: Format) -> frozenset[str]:
    """Views, triggers and CTEs that may run on a connection whose schema has been compared."""
    return form.names_of("view", "trigger") | CTE_NAMES
