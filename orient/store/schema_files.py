"""For developers: write the frozen texts of the format in work anew, `python -m orient.store.schema_files`.

`make schema` does it: migrations/versions/0003_evidence.sql is what leads from the tables of the migrations before
it to those of models.py, and schema.json is a fresh file (tables, guards, views). Call it after a change of models.py,
guards.sql or views.sql. The texts before it are never written again: files of formats 1 and 2 exist. Once format 3 is
released, the next change of the tables is migration 0004, made in the same way.
"""

import re
from collections.abc import Iterator
from pathlib import Path

from orient.errors import OrientError
from orient.store.creation import migrations_folder, write_expected_schema

BEFORE = (Path("versions", "0001_initial.sql"), Path("versions", "0002_absolute.sql"))
IN_WORK = Path("versions", "0003_evidence.sql")
END = ";\n\n"
TABLE = re.compile(r'CREATE TABLE "?(\w+)"?')

Ddl = dict[str, tuple[str, list[str]]]
"""CREATE TABLE and the CREATE INDEX of each table."""


def models_ddl() -> Ddl:
    """What models.py asks for, in order of the dependencies."""
    from sqlalchemy.dialects import sqlite
    from sqlalchemy.schema import CreateIndex, CreateTable

    from orient.models import Base

    dialect = sqlite.dialect()
    made: Ddl = {}
    for table in Base.metadata.sorted_tables:
        indexes = sorted(table.indexes, key=lambda index: str(index.name))
        statements = [str(CreateIndex(index).compile(dialect=dialect)).strip() for index in indexes]
        made[table.name] = (str(CreateTable(table).compile(dialect=dialect)).strip(), statements)
    return made


def migration_ddl(before: dict[str, str], after: Ddl) -> str:
    """SQL from the tables `before` (name -> CREATE TABLE) to those `after`; a changed table is rebuilt with
    its rows, which is right as long as no other table refers to it."""
    if gone := sorted(before.keys() - after.keys()):
        raise OrientError(f"tables cannot go: {', '.join(gone)}", "Rows that somebody sealed must stay readable.")
    statements: list[str] = []
    for name, (create, indexes) in after.items():
        if name not in before:
            statements += [create, *indexes]
        elif before[name] != create:
            statements += [*_rebuilt(name, before[name], create), *indexes]
    return END.join(statements) + ";\n"


def _rebuilt(name: str, old: str, new: str) -> Iterator[str]:
    """SQLite cannot add a constraint to a table. The old name is free first, so that the stored text is the models'."""
    columns = ", ".join(f'"{column}"' for column in _columns(old))
    yield f"ALTER TABLE {name} RENAME TO before_{name}"
    yield new
    yield f"INSERT INTO {name} ({columns}) SELECT {columns} FROM before_{name}"
    yield f"DROP TABLE before_{name}"


def _columns(create: str) -> list[str]:
    return re.findall(r'^\t"?(\w+)"? (?:INTEGER|REAL|TEXT|BLOB)', create, re.MULTILINE)


def frozen_tables(texts: list[str]) -> dict[str, str]:
    """name -> CREATE TABLE as the migrations up to now left it."""
    statements = [statement.strip() for text in texts for statement in text.split(";\n")]
    return {match[1]: statement for statement in statements if (match := TABLE.match(statement))}


def write_schema_files() -> None:
    """The migration first: a fresh file is made from it."""
    folder = migrations_folder()
    before = frozen_tables([(folder / name).read_text(encoding="utf-8") for name in BEFORE])
    (folder / IN_WORK).write_text(migration_ddl(before, models_ddl()), encoding="utf-8")
    write_expected_schema()


if __name__ == "__main__":
    write_schema_files()
