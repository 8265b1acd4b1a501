"""Commands about versions and the file: status, log, show, diff, select, check, backup, receive, upgrade."""

from pathlib import Path
from typing import Annotated

import typer

from orient.cli.completion import stage_names
from orient.cli.options import AsJson, ProjectPath, Reason, project_path

StageName = Annotated[
    str,
    typer.Argument(
        metavar="STAGE",
        autocompletion=stage_names,
        help="photo, readings, ..., refine, ..., covariance, absolute, verify.",
    ),
]


def register(app: typer.Typer) -> None:
    for command in (status, log, show, diff, select, check, backup, receive, upgrade):
        app.command()(command)


def status(project: ProjectPath, as_json: AsJson = False) -> None:
    """The verdict and its problems; what is there, what is current, what is stale and why."""
    from orient.report.status import show_status

    show_status(project, as_json)


def log(project: ProjectPath, as_json: AsJson = False) -> None:
    """Who did what, when and why: every run and every selection."""
    from orient.report.status import show_log

    show_log(project, as_json)


def show(
    project: ProjectPath,
    stage: Annotated[
        str,
        typer.Argument(
            metavar="[STAGE]",
            autocompletion=stage_names,
            help="photo, ..., covariance, verify; without it, the orientation.",
        ),
    ] = "",
    version: Annotated[int | None, typer.Option("--version", min=1, help="Not the current one.")] = None,
    as_json: AsJson = False,
) -> None:
    """The result of a stage: what to know first, then the numbers. Exit code 1 if this version failed."""
    from orient.report.show import show_stage

    if not show_stage(project, stage, version, as_json):
        raise typer.Exit(1)


def diff(
    project: ProjectPath,
    stage: StageName,
    first: Annotated[int, typer.Argument(metavar="A", min=1, help="Version.")],
    second: Annotated[int, typer.Argument(metavar="B", min=1, help="Version to compare with.")],
    as_json: AsJson = False,
) -> None:
    """What changed between two versions of a stage: settings, inputs, rows, numbers."""
    from orient.report.diff import show_diff

    show_diff(project, stage, first, second, as_json)


NONE = 0


def _version(text: str) -> int:
    """The number of a version; NONE for none."""
    if text == "none":
        return NONE
    if not (text.isascii() and text.isdigit() and int(text) > 0):
        raise typer.BadParameter(f"{text!r} is no version: give a number from 1 on, or none.")
    return int(text)


def select(
    project: ProjectPath,
    stage: StageName,
    version: Annotated[
        int, typer.Argument(metavar="VERSION|none", parser=_version, help="Version that becomes current, or none.")
    ],
    message: Reason = "",
) -> None:
    """Make another version of a stage or list current (undo). Nothing is deleted; the choice is recorded.

    none: the stage or list has no current version from now on, nor has what cannot be computed without it. So a list
    that was added by mistake is taken back.
    """
    from orient.pipeline.runner import select_version, withdraw
    from orient.report.runs import show_selected, show_withdrawn

    if version == NONE:
        show_withdrawn(withdraw(project, stage, message))
    else:
        show_selected(select_version(project, stage, version, message))


def check(project: ProjectPath) -> None:
    """Examine the whole file: structure, seals, and the digest of every run."""
    from orient.report.check import show_check

    show_check(project)


def backup(
    project: ProjectPath,
    target: Annotated[
        Path | None,
        typer.Argument(
            metavar="[COPY]", parser=project_path, help="A new name; by default beside the project, with the time."
        ),
    ] = None,
) -> None:
    """Copy the project as it is at this moment, also while others work on it, and verify every digest of the copy."""
    from orient.report.check import show_backup

    show_backup(project, target)


def receive(
    stranger: Annotated[
        Path, typer.Argument(metavar="STRANGER", parser=project_path, help="A project file that somebody sent.")
    ],
    target: Annotated[Path, typer.Argument(metavar="COPY", parser=project_path, help="A new name for the clean copy.")],
) -> None:
    """Make a clean, verified copy of a project of unknown origin, or say why not. The file sent is never opened."""
    from orient.report.check import show_received

    show_received(stranger, target)


def upgrade(project: ProjectPath) -> None:
    """Bring a project of an older orient to this version's format; the old file is kept beside it."""
    from orient.report.check import show_upgrade

    show_upgrade(project)
