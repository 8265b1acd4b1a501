"""The command `report`: one page that a reviewer accepts."""

from pathlib import Path
from typing import Annotated

import typer

from orient.cli.options import Language, ProjectPath

STDOUT = "-"
HTML, PDF = ".html", ".pdf"


def register(app: typer.Typer) -> None:
    app.command()(report)


def report(
    project: ProjectPath,
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FILE.html|FILE.pdf|-", help="The report; - is HTML to the output.")
    ],
    language: Language = "en",
    force: Annotated[bool, typer.Option("--force", help="Replace the file if it exists.")] = False,
) -> None:
    """Write the report: findings, orientation, residuals, reliability, accuracy, provenance. Needs orient[report].

    One file with everything inside and no address outside; the same project gives the same bytes. A name in .pdf needs
    orient[pdf].
    """
    import sys

    from orient.errors import UsageError
    from orient.report.html.render import make_report
    from orient.report.output_file import output_path, write_output

    if output == STDOUT:
        sys.stdout.buffer.write(make_report(project, language))
        return
    ending = Path(output).suffix.lower()
    if ending not in (HTML, PDF):
        raise UsageError(f'"{output}": the name of a report ends in .html or .pdf')
    target = output_path(output, project, force)
    if ending == HTML:
        content = make_report(project, language)
    else:
        from orient.report.html.pdf import make_pdf

        content = make_pdf(project, language)
    write_output(target, content, project, force)
