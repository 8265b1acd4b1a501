"""Writes cli.md, schema.md, summary.md of docs from the code: `python -m orient.cli.reference FOLDER [--check]`."""

import inspect
import os
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from orient.store.stage_tables import LEDGER_TABLES, STAGE_TABLES, TEST_TABLES
from orient.store.views import view_texts

if TYPE_CHECKING:
    from sqlalchemy import Column

MADE = "<!-- Made from the code by `make docs`; do not edit. -->\n\n"
HELP_WIDTH = "100"
SUMMARY_INTRO = """`orient batch` writes these tables (batch.md). View `orient_latest` has the columns of
`orient_photo`, each photo once as the last batch that worked on it has left it. All names are lower case; angles in
degrees, lengths in metres, image coordinates in millimetres. Numbers are those of the project, unchanged.
"""


def command_page() -> str:
    """Every command's own `--help`."""
    os.environ.update(COLUMNS=HELP_WIDTH, TERMINAL_WIDTH=HELP_WIDTH, NO_COLOR="1")
    from typer.main import get_command
    from typer.testing import CliRunner

    from orient.cli.command_line import command_line

    app = command_line()
    names = list(get_command(app).commands)  # type: ignore[attr-defined]
    parts = ["# Commands\n\n" + MADE + _help(CliRunner(), app, [])]
    parts += [f"## orient {name}\n\n" + _help(CliRunner(), app, [name]) for name in names]
    return "\n".join(parts)


def _help(runner: object, app: object, words: list[str]) -> str:
    result = runner.invoke(app, [*words, "--help"], prog_name="orient")  # type: ignore[attr-defined]
    lines = [line.rstrip() for line in result.output.strip().splitlines()]
    return "```\n" + "\n".join(lines) + "\n```\n"


def schema_page() -> str:
    """Every table and view with the meaning of its columns."""
    parts = ["# The project file\n\n" + MADE, *_intro(), "## Views\n", *_views(), "## Tables\n", *_tables()]
    return "\n".join(parts)


def _intro() -> Iterator[str]:
    yield (
        "A project is one SQLite file. A row belongs to one run of a stage and is never changed; the current version\n"
        "of a stage is the newest row of `selection`. Read it with any SQLite program, or with `orient sql`.\n"
    )


def _views() -> Iterator[str]:
    for view in view_texts():
        yield f"\n### {view.name}\n\n{view.question}\n\n| column | meaning |\n|---|---|"
        yield from (_row(name, text) for name, text in view.columns.items())
    yield ""


def _tables() -> Iterator[str]:
    from orient.models import Base

    classes = {str(mapper.class_.__tablename__): mapper.class_ for mapper in Base.registry.mappers}
    own = {
        f"Stage {stage}": [name for name in tables if name not in TEST_TABLES] for stage, tables in STAGE_TABLES.items()
    }
    groups = {"The ledger": LEDGER_TABLES, **own, "Tests of the adjustments (digitize, resection)": TEST_TABLES}
    for group, tables in groups.items():
        yield f"\n### {group}\n"
        for name in tables:
            yield from _table(name, inspect.cleandoc(classes[name].__doc__ or ""), classes[name].__table__.columns)


def summary_page() -> str:
    """Every table of the summary of `orient batch`."""
    from orient.batch.tables import METADATA

    parts = ["# The summary of a batch\n\n" + MADE, SUMMARY_INTRO]
    for name, table in METADATA.tables.items():
        parts += _table(name, table.comment or "", table.columns)
    return "\n".join(parts)


def _table(name: str, about: str, columns: "Iterable[Column[object]]") -> Iterator[str]:
    yield f"#### {name}\n\n{about}\n\n| column | type | meaning |\n|---|---|---|"
    for column in columns:
        kind = f"{column.type}{'' if column.nullable else ' NOT NULL'}{', key' if column.primary_key else ''}"
        yield f"| `{column.name}` | {kind} | {_escaped(column.comment or '')} |"
    yield ""


def _row(name: str, text: str) -> str:
    return f"| `{name}` | {_escaped(text)} |"


def _escaped(text: str) -> str:
    return text.replace("|", "\\|")


def main(arguments: list[str]) -> int:
    """0 if the pages are written or up to date."""
    folder, only_check = Path(arguments[0]), "--check" in arguments
    makers = {"cli.md": command_page, "schema.md": schema_page, "summary.md": summary_page}
    pages = {folder / name: make() for name, make in makers.items()}
    stale = [path for path, text in pages.items() if not path.exists() or path.read_text("utf-8") != text]
    if only_check:
        for path in stale:
            print(f"{path} is not up to date; run: make docs", file=sys.stderr)
        return 1 if stale else 0
    for path, text in pages.items():
        path.write_text(text, "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
