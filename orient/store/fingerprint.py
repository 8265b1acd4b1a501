"""The gate: the schema text in the file must equal, byte for byte, the text that this program writes."""

from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from sqlalchemy import Connection

from orient.errors import ProjectError
from orient.store.connection import execute, scalar
from orient.store.errors import Corrupt
from orient.store.format import Format, SchemaObject, TableShape
from orient.store.guards import quoted
from orient.units import listed

ALTERED = "Another program altered it; use a backup."
NAMED = 3
"""How many strange objects a message names."""


def schema_objects(connection: Connection) -> list[SchemaObject]:
    """Rows of sqlite_schema in the order of type and name; statistics tables are not looked at."""
    query = (
        "SELECT type, name, tbl_name, sql FROM main.sqlite_schema "
        "WHERE NOT (type = 'table' AND name LIKE 'sqlite_stat_') ORDER BY type, name, tbl_name, sql"
    )
    return execute(connection, query).fetchall()


def tables_and_indexes(connection: Connection) -> list[SchemaObject]:
    return [item for item in schema_objects(connection) if item[0] in ("table", "index")]


def check_fingerprint(connection: Connection, form: Format, path: Path) -> None:
    """Refuse a file with objects too many, too few or other than those of `form`, naming up to three."""
    count = scalar(connection, "SELECT count(*) FROM main.sqlite_schema")
    if count > len(form.objects) + 20:
        raise _foreign(path, f"{count} tables, views, triggers and indexes instead of {len(form.objects)}")
    objects = schema_objects(connection)
    if tuple(objects) != form.objects:
        compare_objects(objects, form.objects, path)
    check_migration(connection, form.head, path)


def compare_objects(are: Iterable[SchemaObject], should_be: Iterable[SchemaObject], path: Path) -> None:
    """Refuse what is not as it should be, text by text."""
    objects = [((kind, name), (table, sql)) for kind, name, table, sql in are]
    found = dict(objects)
    expected = {(kind, name): (table, sql) for kind, name, table, sql in should_be}
    if extra := sorted(found.keys() - expected.keys(), key=str):
        raise _foreign(path, _named(extra))
    if missing := sorted(expected.keys() - found.keys()):
        raise ProjectError(f"{path}: objects are missing: {_named(missing)}.", "Use a backup.")
    if other := [key for key in expected if expected[key] != found[key]]:
        raise ProjectError(f"{path}: the schema differs in {_named(other)}.", ALTERED)
    if twice := [key for key, times in Counter(key for key, _ in objects).items() if times > 1]:
        raise _foreign(path, f"{_named(twice)} more than once")


def _foreign(path: Path, what: str) -> ProjectError:
    return ProjectError(f"{path} contains objects orient never makes: {what}.", ALTERED)


def _named(keys: list[tuple[str, str]]) -> str:
    return listed([f"{kind} {str(name)[:60]!r}" for kind, name in keys], NAMED)


def check_migration(connection: Connection, head: str, path: Path) -> None:
    if execute(connection, "SELECT version_num FROM alembic_version LIMIT 2").fetchall() != [(head,)]:
        raise ProjectError(
            f"{path}: an upgrade was not finished by a program that does not protect it.", "Use the backup."
        )


def check_pages(connection: Connection, path: Path, thorough: bool = False) -> None:
    """quick_check (integrity_check if thorough) and foreign_key_check, or `Corrupt` with their first words."""
    pragma = "integrity_check" if thorough else "quick_check"
    lines = execute(connection, f"PRAGMA {pragma}(3)").fetchall()
    if lines != [("ok",)]:
        raise Corrupt(f"{path} is damaged ({str(lines[0][0])[:120]}).", "Use a backup. Nothing was changed.")
    orphans = execute(connection, "PRAGMA foreign_key_check").fetchall()
    if orphans:
        raise Corrupt(f'{path} is damaged (dangling references in table "{orphans[0][0]}").', "Use a backup.")


def table_shapes(connection: Connection) -> dict[str, TableShape]:
    """Columns and primary key of every table of the file."""
    names = [name for kind, name, _, _ in schema_objects(connection) if kind == "table"]
    shapes = {}
    for name in names:
        rows = connection.exec_driver_sql(f"PRAGMA main.table_info({quoted(name)})").all()
        key = sorted((row[5], row[1]) for row in rows if row[5])
        shapes[name] = TableShape(tuple((row[1], row[2]) for row in rows), tuple(column for _, column in key))
    return shapes
