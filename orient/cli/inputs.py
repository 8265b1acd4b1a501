"""Commands that bring data in: new, add."""

from pathlib import Path
from typing import Annotated

import typer

from orient.cli.completion import from_words, list_names
from orient.cli.options import Again, ProjectPath, Reason, valid_text
from orient.intake.options import MAX_ROWS

Decimal = Annotated[
    str,
    typer.Option(
        "--decimal",
        metavar="point|comma",
        autocompletion=from_words(("point", "comma")),
        help="Decimal sign of the CSV files.",
    ),
]
Encoding = Annotated[str, typer.Option("--encoding", help="Encoding of the files.")]
IgnoreColumns = Annotated[bool, typer.Option("--ignore-columns", help="Pass over columns that orient does not know.")]
MaxRows = Annotated[int, typer.Option("--max-rows", min=1, help="Most data lines in one file.")]


def register(app: typer.Typer) -> None:
    app.command()(new)
    app.command()(add)


def new(
    project: ProjectPath,
    folder: Annotated[Path, typer.Option("--from", metavar="FOLDER", help="Folder with photo.toml and the lists.")],
    message: Reason = "new project",
    decimal: Decimal = "point",
    encoding: Encoding = "utf-8",
    ignore_columns: IgnoreColumns = False,
    max_rows: MaxRows = MAX_ROWS,
) -> None:
    """Make a project from a folder with photo.toml and the lists of points.

    The folder holds photo.toml and any of readings.csv, crosses.csv, digitizer.csv, sheet.toml, control.csv,
    control.toml, model.csv. Everything is read and checked first; one mistake anywhere, and no file is made.
    """
    from orient.intake.project_folder import read_project
    from orient.intake.text_file import read_options
    from orient.pipeline.runner import create
    from orient.report.runs import show_inputs

    inputs = read_project(folder, read_options(decimal, encoding, ignore_columns, max_rows))
    create(project, inputs, message)
    show_inputs(project, inputs)


def add(
    project: ProjectPath,
    what: Annotated[
        str, typer.Argument(metavar="LIST", autocompletion=list_names, help="photo, readings, sheet, control or model.")
    ],
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="The CSV and TOML files of the list.")],
    message: Annotated[
        str, typer.Option("--message", "-m", callback=valid_text, help="Why; it is kept with the version.")
    ],
    again: Again = False,
    decimal: Decimal = "point",
    encoding: Encoding = "utf-8",
    ignore_columns: IgnoreColumns = False,
    max_rows: MaxRows = MAX_ROWS,
) -> None:
    """Add a new version of one list: nothing is overwritten, results that used the old one become stale."""
    from orient.errors import UsageError
    from orient.intake.project_folder import read_input
    from orient.intake.text_file import read_options
    from orient.pipeline.registry import INPUT_STAGES
    from orient.pipeline.runner import add_input, photo_facts
    from orient.report.runs import show_added

    if what not in INPUT_STAGES:
        raise UsageError(f'there is no list "{what}"', f"Lists are {', '.join(INPUT_STAGES)}.")
    options = read_options(decimal, encoding, ignore_columns, max_rows)
    given = read_input(what, files, options, photo_facts(project))
    show_added(add_input(project, given, message, again))
