"""The command `audit`: the questions of a suspicious reviewer, in the terminal or in a browser."""

from typing import Annotated

import typer

from orient.cli.options import ProjectPath, valid_text

PORT = 8765


def register(app: typer.Typer) -> None:
    app.command()(audit)


def audit(
    project: ProjectPath,
    serve: Annotated[
        bool, typer.Option("--serve", help="Serve a verified read-only copy to a browser. Needs orient[audit].")
    ] = False,
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="Port on 127.0.0.1; 0: any free one.")] = PORT,
    browser: Annotated[bool, typer.Option("--open/--no-browser", help="Open the browser.")] = False,
    downloads: Annotated[
        bool, typer.Option("--downloads", help="Let the browser download the whole copy and whole tables.")
    ] = False,
    source: Annotated[str, typer.Option("--source", callback=valid_text, help="Source of the photo, shown.")] = "",
    licence: Annotated[str, typer.Option("--licence", callback=valid_text, help="Licence of the data, shown.")] = "",
) -> None:
    """Answer ten questions of a suspicious reviewer; each is a ready question of `orient sql` too.

    With --serve, Datasette shows all tables, views and questions at http://127.0.0.1, to this machine alone, until
    Ctrl-C. It reads a temporary copy in which every digest was verified; the project itself is not touched.
    """
    if serve:
        from orient.report.audit_server import Served
        from orient.report.audit_server import serve as serve_copy

        serve_copy(project, Served(port, downloads, browser, source, licence))
        return
    from orient.report.audit import show_audit

    show_audit(project)
