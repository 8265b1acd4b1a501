"""The command `orient`: the list of commands, and the way in."""

import os
import sys

import typer
from typer.models import CommandInfo

from orient.cli import (
    audit,
    batch,
    explain,
    export,
    inputs,
    ledger,
    plan,
    plot,
    questions,
    report,
    seal,
    stages,
    verify,
)
from orient.cli.ending import exit_code, listen, no_more_signals

COMPLETING, ONE_LINE = "_ORIENT_COMPLETE", "10000"
APP_HELP = """Orient one frame photograph from measured image points and a map, and keep the whole proof in one file.

A project is one SQLite file per photo. Start with:

\b
    orient new photo.sqlite --from FOLDER
    orient run photo.sqlite
    orient show photo.sqlite resection

Exit codes: 0 done, 1 the data or the geometry says no, 2 wrong use, 3 the project file, 70 our own fault.
"""

app = typer.Typer(
    name="orient",
    help=APP_HELP,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _show_version(value: bool) -> None:
    if value:
        from orient import __version__

        typer.echo(f"orient {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: bool = typer.Option(False, "--version", callback=_show_version, is_eager=True, help="Print the version."),
) -> None:
    """Options of orient itself."""


for group in (inputs, stages, batch, ledger, verify, seal, questions, audit, plan, plot, report, export, explain):
    group.register(app)


def run() -> None:
    """Entry point: run the command, end with the exit code of what happened."""
    listen()
    if sys.stdout is None:  # closed by the caller: `orient run P >&-`
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  (for the life of the process)
    if COMPLETING in os.environ:
        os.environ["TERMINAL_WIDTH"] = ONE_LINE  # a name offered to the shell and what it means are one line
    everything = app.registered_commands
    app.registered_commands = _named(everything, sys.argv[1:]) or everything
    code = exit_code(app)
    app.registered_commands = everything
    no_more_signals()
    sys.exit(code)


def _named(commands: list[CommandInfo], words: list[str]) -> list[CommandInfo]:
    """The command that the first word names: typer would build all of them, with all their options."""
    return [command for command in commands if command.callback and [command.callback.__name__] == words[:1]]
