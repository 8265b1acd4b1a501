"""Rows have the columns of the project file's tables: all that must be there, and none that are not."""

from pathlib import Path

from orient.intake.project_folder import ReadOptions, read_project
from orient.models import Base
from tests.intake.test_docs import DOCUMENT, EXAMPLE


def test_rows_have_the_columns_of_the_tables(tmp_path: Path) -> None:
    for name, text in EXAMPLE.findall(DOCUMENT.read_text(encoding="utf-8")):
        (tmp_path / name).write_text(text, encoding="utf-8")
    for tables in read_project(tmp_path, ReadOptions()):
        for name, rows in tables.tables.items():
            columns = {column.name for column in Base.metadata.tables[name].columns} - {"run_id"}
            assert all(set(row) == columns for row in rows), name
