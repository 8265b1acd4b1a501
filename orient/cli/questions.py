"""The command `sql`: ready-made questions by name, or any SELECT, read-only."""

from typing import Annotated

import typer

from orient.cli.completion import question_names
from orient.cli.options import AsJson, ProjectPath, valid_text


def register(app: typer.Typer) -> None:
    app.command()(sql)


def sql(
    project: ProjectPath,
    question: Annotated[
        str,
        typer.Argument(
            metavar="QUESTION",
            autocompletion=question_names,
            callback=valid_text,
            help='A name from --list, or SQL such as "SELECT * FROM v_residual".',
        ),
    ] = "",
    as_list: Annotated[bool, typer.Option("--list", help="The ready-made questions, by name.")] = False,
    as_csv: Annotated[bool, typer.Option("--csv", help="Answer as CSV, with all digits.")] = False,
    raw: Annotated[bool, typer.Option("--raw", help="CSV without the guard against formulas in text cells.")] = False,
    as_json: AsJson = False,
    sets: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="NAME=VALUE", help="What stands for :NAME, as text (numbers: CAST(:NAME AS REAL))."
        ),
    ] = None,
) -> None:
    """Ask the project file. It cannot be changed this way; tables and views are described in docs/schema.md."""
    from orient.report.question import settings_of
    from orient.report.questions import answer, list_questions

    if as_list or not question:
        list_questions(as_json)
    else:
        answer(project, question, as_csv, as_json, raw, settings_of([valid_text(pair) for pair in sets or []]))
