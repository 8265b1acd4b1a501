"""The command `plot`: one picture of the current results."""

from typing import Annotated

import typer

from orient.cli.completion import plot_names
from orient.cli.options import Force, Language, ProjectPath, valid_text


def register(app: typer.Typer) -> None:
    app.command()(plot)


def plot(
    project: ProjectPath,
    kind: Annotated[
        str,
        typer.Argument(
            metavar="accuracy|budget|ellipses|iterations|residuals|sheet",
            callback=valid_text,
            autocompletion=plot_names,
            help="What is drawn.",
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
    force: Force = False,
) -> None:
    """Draw ground accuracy, error budget, ellipses, iterations, residuals or a map sheet. Needs orient[plot]."""
    import sys

    from orient.report.language import speaking
    from orient.report.output_file import STDOUT, ending_of, output_path, write_output
    from orient.report.plots import ENDINGS, make_plot, plot_named

    plot_named(kind)
    with speaking(language):
        if output == STDOUT:
            sys.stdout.write(make_plot(project, kind, "svg", part).decode("utf-8"))
            return
        ending = ending_of(output, ENDINGS, "picture")
        target = output_path(output, project, force)
        write_output(target, make_plot(project, kind, ending[1:], part), project, force)
