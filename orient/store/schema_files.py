"""For developers: write the two frozen texts of the schema anew, `python -m orient.store.schema_files` (`make schema`).

migrations/versions/0001_initial.sql from models.py, and schema.json from a fresh file (tables, guards, views). Call it
after a change of models.py, guards.sql or views.sql. Rewriting 0001 is right only as long as no project of format 1 has
left this repository; from the first release on a change of the tables is a new migration.
"""

from pathlib import Path

from orient.store.creation import migrations_folder, write_expected_schema

INITIAL = Path("versions", "0001_initial.sql")


def initial_ddl() -> str:
    """CREATE TABLE and CREATE INDEX of every table of models.py, in order of their dependencies."""
    from sqlalchemy.dialects import sqlite
    from sqlalchemy.schema import CreateIndex, CreateTable

    from orient.models import Base

    dialect = sqlite.dialect()
    statements = []
    for table in Base.metadata.sorted_tables:
        statements.append(CreateTable(table).compile(dialect=dialect))
        indexes = sorted(table.indexes, key=lambda index: str(index.name))
        statements += [CreateIndex(index).compile(dialect=dialect) for index in indexes]
    return ";\n\n".join(str(statement).strip() for statement in statements) + ";\n"


def write_schema_files() -> None:
    """0001_initial.sql first: a fresh file is made from it."""
    (migrations_folder() / INITIAL).write_text(initial_ddl(), encoding="utf-8")
    write_expected_schema()


if __name__ == "__main__":
    write_schema_files()
