"""The command `explain`: one iteration, to be followed by hand."""

from typing import Annotated

import typer

from orient.cli.completion import from_words
from orient.cli.options import AsJson, ProjectPath, valid_text

FEWEST_DIGITS, MOST_DIGITS = 4, 15


def register(app: typer.Typer) -> None:
    app.command()(explain)


def explain(
    project: ProjectPath,
    stage: Annotated[
        str,
        typer.Argument(
            metavar="[STAGE]", callback=valid_text, autocompletion=from_words(("resection",)), help="resection."
        ),
    ] = "resection",
    iteration: Annotated[int, typer.Option("--iteration", "-k", min=1, help="Which iteration, from 1.")] = 1,
    version: Annotated[int | None, typer.Option("--version", min=1, help="Not the current one.")] = None,
    digits: Annotated[
        int, typer.Option("--digits", min=FEWEST_DIGITS, max=MOST_DIGITS, help="Significant digits of every line.")
    ] = 8,
    as_json: AsJson = False,
) -> None:
    """Print one iteration of the resection as a textbook would: equations, N, every reduction, x, new unknowns.

    Each line follows from the lines above as they are printed, so that it can be checked by hand.
    """
    from orient.report.explain import explain as print_page

    print_page(project, stage, iteration, version, digits, as_json)
