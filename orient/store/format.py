"""The format of a project file as this program writes it: version, schema text, columns. Read from schema.json."""

import json
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

SCHEMA_FILE = Path(__file__).with_name("schema.json")

SchemaObject = tuple[str, str, str, str | None]
"""type, name, table, SQL text: a row of sqlite_schema."""


@dataclass(frozen=True)
class TableShape:
    """Columns in stored order as (name, type), and the names of the primary key."""

    columns: tuple[tuple[str, str], ...]
    key: tuple[str, ...]

    @cached_property
    def names(self) -> tuple[str, ...]:
        return tuple(name for name, _ in self.columns)

    @cached_property
    def own(self) -> tuple[str, ...]:
        """All names but `run_id`."""
        return tuple(name for name in self.names if name != "run_id")

    @cached_property
    def has_bytes(self) -> bool:
        return any(kind == "BLOB" for _, kind in self.columns)


@dataclass(frozen=True)
class Format:
    """Everything that two files of one format have in common."""

    version: int
    application_id: int
    head: str
    objects: tuple[SchemaObject, ...]
    tables: dict[str, TableShape]

    def names_of(self, *kinds: str) -> frozenset[str]:
        return frozenset(name for kind, name, _, _ in self.objects if kind in kinds)


@cache
def current_format() -> Format:
    return format_from_json(SCHEMA_FILE.read_text(encoding="utf-8"))


def format_from_json(text: str) -> Format:
    content = json.loads(text)
    tables = {
        name: TableShape(tuple((column[0], column[1]) for column in shape["columns"]), tuple(shape["key"]))
        for name, shape in content["tables"].items()
    }
    objects = tuple((kind, name, table, sql) for kind, name, table, sql in content["objects"])
    return Format(content["version"], content["application_id"], content["head"], objects, tables)


def json_from_format(form: Format) -> str:
    """One line for each table and object, so that a change shows as a small difference."""
    shapes = {name: {"columns": shape.columns, "key": shape.key} for name, shape in form.tables.items()}
    tables = ",\n".join(f"{json.dumps(name)}: {json.dumps(shape)}" for name, shape in shapes.items())
    objects = ",\n".join(json.dumps(item, ensure_ascii=False) for item in form.objects)
    head = f'"version": {form.version}, "application_id": {form.application_id}, "head": {json.dumps(form.head)}'
    return f'{{{head},\n"tables": {{\n{tables}\n}},\n"objects": [\n{objects}\n]}}\n'
