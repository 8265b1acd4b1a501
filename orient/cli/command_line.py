"""The command `orient`: the list of commands."""

from collections.abc import Iterable
from importlib import import_module

import typer

APP_HELP = """Orient one frame photograph from measured image points and a map, and keep the whole proof in one file.

A project is one SQLite file per photo. Start with:

\b
    orient new photo.sqlite --from FOLDER
    orient run photo.sqlite
    orient show photo.sqlite resection

Exit codes: 0 done, 1 the data or the geometry says no, 2 wrong use, 3 the project file, 70 our own fault.
"""

GROUPS = {
    "inputs": "new add",
    "stages": "run refine digitize bl topocentric resection covariance absolute",
    "batch": "batch",
    "ledger": "status log show diff select check backup receive upgrade",
    "verify": "verify",
    "seal": "seal image",
    "questions": "sql",
    "audit": "audit",
    "plan": "plan",
    "plot": "plot",
    "report": "report",
    "export": "export",
    "explain": "explain",
}
"""Each module of commands and what it registers, in the order of `--help`: only what is called is loaded."""


def _show_version(value: bool) -> None:
    if value:
        from orient import __version__

        typer.echo(f"orient {__version__}")
        raise typer.Exit


def _options(
    version: bool = typer.Option(False, "--version", callback=_show_version, is_eager=True, help="Print the version."),
) -> None:
    """Options of orient itself."""


def command_line(groups: Iterable[str] = GROUPS) -> typer.Typer:
    """The commands of some modules, all by default."""
    app = typer.Typer(
        name="orient",
        help=APP_HELP,
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(_options)
    for group in groups:
        import_module(f"orient.cli.{group}").register(app)
    return app


def called(words: list[str]) -> typer.Typer:
    """The command that the first word names: typer would build all of them, with all their options."""
    groups = [group for group, names in GROUPS.items() if words and words[0] in names.split()]
    if not groups:
        return command_line()
    app = command_line(groups)
    app.registered_commands = [
        command for command in app.registered_commands if command.callback and [command.callback.__name__] == words
    ]
    return app
