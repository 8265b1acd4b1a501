"""The command `plot`: one picture of the current results."""

from pathlib import Path
from typing import Annotated

import typer

from orient.cli.options import Language, ProjectPath, valid_text

STDOUT = "-"


def register(app: typer.Typer) -> None:
    app.command()(plot)


def plot(
    project: ProjectPath,
    kind: Annotated[
        str,
        typer.Argument(
            metavar="accuracy|budget|ellipses|iterations|residuals|sheet", callback=valid_text, help="What is drawn."
        ),
    ],
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FILE.svg|FILE.png|-", help="The picture; - is SVG to the output.")
    ],
    part: Annotated[
        str,
        typer.Option("--part", callback=valid_text, help="The map sheet, or the zone of a model, if it has several."),
    ] = "",
    language: Language = "en",
    force: Annotated[bool, typer.Option("--force", help="Replace the file if it exists.")] = False,
) -> None:
    """Draw ground accuracy, error budget, ellipses, iterations, residuals or a map sheet. Needs orient[plot]."""
    import sys

    from orient.errors import UsageError
    from orient.report.language import speaking
    from orient.report.output_file import output_path, write_output
    from orient.report.plots import BY_NAME, FORMATS, make_plot

    if kind not in BY_NAME:
        raise UsageError(f'there is no plot "{kind}"', f"Plots are {', '.join(BY_NAME)}.")
    with speaking(language):
        if output == STDOUT:
            sys.stdout.write(make_plot(project, kind, "svg", part).decode("utf-8"))
            return
        format_name = Path(output).suffix.lower().removeprefix(".")
        if format_name not in FORMATS:
            raise UsageError(f'"{output}": the name of a picture ends in .svg or .png')
        target = output_path(output, project, force)
        write_output(target, make_plot(project, kind, format_name, part), project, force)
