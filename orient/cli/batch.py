"""The command that works through many photos: batch."""

from typing import Annotated

import typer

from orient.cli.inputs import Decimal, Encoding, IgnoreColumns
from orient.cli.options import AsJson, Reason
from orient.cli.settings import AllowBallpark, CameraUse, Control, Engine, Reject, Robust, Variance, settings_of
from orient.errors import UsageError


def register(app: typer.Typer) -> None:
    app.command()(batch)


def batch(
    places: Annotated[
        list[str],
        typer.Argument(metavar="DIR|LIST...", help="Folders of projects, or lists of paths (-: input)."),
    ],
    workers: Annotated[
        int | None,
        typer.Option("--workers", min=0, max=1024, help="Workers on this machine; usually one per processor. 0: none."),
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option("--scheduler", metavar="ADDRESS", help="Use this dask scheduler: tcp://HOST:8786.")
    ] = None,
    summary: Annotated[
        str | None,
        typer.Option(
            "--summary", metavar="FILE|URL", help="SQLite file, or database URL. Usually DIR/orient-summary.db."
        ),
    ] = None,
    folders: Annotated[
        str | None,
        typer.Option("--from", metavar="FOLDER", help="Make DIR/NAME.sqlite of each FOLDER/NAME with photo.toml."),
    ] = None,
    pattern: Annotated[str, typer.Option("--pattern", help="Which files of a folder are projects.")] = "*.sqlite",
    recursive: Annotated[bool, typer.Option("--recursive", "-r", help="Also in the folders of the folders.")] = False,
    message: Reason = "batch",
    retry_failed: Annotated[
        bool, typer.Option("--retry-failed", help="Also try again what the data refused and is as it was.")
    ] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only say what would be done.")] = False,
    as_json: AsJson = False,
    memory_mib: Annotated[
        int | None,
        typer.Option("--memory-mib", min=128, help="A local worker above it is ended; usually its share of memory."),
    ] = None,
    allow_ballpark: AllowBallpark = None,
    reject: Reject = None,
    robust: Robust = None,
    control: Control = None,
    camera: CameraUse = None,
    variance: Variance = None,
    engine: Engine = None,
    decimal: Decimal = "point",
    encoding: Encoding = "utf-8",
    ignore_columns: IgnoreColumns = False,
) -> None:
    """Run many projects on all processors, or on a dask cluster; one summary database tells how each photo ended.

    What is done is not done again: the same command goes on after a stop, and computes only what has changed. One bad
    file never stops the rest. Exit codes: 0 every photo has a result, 1 some have none, the others as everywhere.
    """
    from orient.batch.command import Wish, carry_out
    from orient.batch.values import Order
    from orient.intake.text_file import read_options

    if workers is not None and scheduler is not None:
        raise UsageError("--workers and --scheduler exclude each other", "A scheduler has its own workers.")
    if memory_mib is not None and (scheduler is not None or workers == 0):
        raise UsageError("--memory-mib is for local workers", "Limit the others where they are started.")
    settings = settings_of(
        allow_ballpark=allow_ballpark, reject=reject, robust=robust, control=control, camera=camera,
        variance=variance, engine=engine,
    )  # fmt: skip
    wish = Wish(
        places=tuple(places),
        pattern=pattern,
        is_recursive=recursive,
        source=folders or "",
        summary=summary or "",
        order=Order(settings, message, read_options(decimal, encoding, ignore_columns)),
        workers=workers,
        memory_mib=memory_mib,
        scheduler=scheduler or "",
        retry_failed=retry_failed,
    )
    raise typer.Exit(carry_out(wish, dry_run=dry_run, as_json=as_json))
