"""The command `report`: one page that a reviewer accepts."""

from typing import Annotated

import typer

from orient.cli.options import Force, Language, ProjectPath

HTML, PDF = ".html", ".pdf"


def register(app: typer.Typer) -> None:
    app.command()(report)


def report(
    project: ProjectPath,
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FILE.html|FILE.pdf|-", help="The report; - is HTML to the output.")
    ],
    language: Language = "en",
    force: Force = False,
) -> None:
    """Write the report: findings, orientation, residuals, reliability, accuracy, provenance. Needs orient[report].

    One file with everything inside and no address outside; the same project gives the same bytes. A name in .pdf needs
    orient[pdf].
    """
    import sys

    from orient.report.html.render import make_report
    from orient.report.output_file import STDOUT, ending_of, output_path, write_output

    if output == STDOUT:
        sys.stdout.buffer.write(make_report(project, language))
        return
    ending = ending_of(output, (HTML, PDF), "report")
    target = output_path(output, project, force)
    if ending == HTML:
        content = make_report(project, language)
    else:
        from orient.report.html.pdf import make_pdf

        content = make_pdf(project, language)
    write_output(target, content, project, force)
