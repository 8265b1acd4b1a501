"""The command `verify`: everything computed again, compared, and the verdict kept as evidence."""

from typing import Annotated

import typer

from orient.cli.options import AsJson, ProjectPath, Reason

MOST_SIMULATIONS = 1_000_000
LARGEST_SEED = 2**63 - 1


def register(app: typer.Typer) -> None:
    app.command()(verify)


def verify(
    project: ProjectPath,
    message: Reason = "verify",
    simulate: Annotated[
        int,
        typer.Option(
            "--simulate", metavar="N", min=0, max=MOST_SIMULATIONS, help="Also N simulated adjustments (Monte Carlo)."
        ),
    ] = 0,
    seed: Annotated[int, typer.Option("--seed", min=0, max=LARGEST_SEED, help="Seed of the simulation.")] = 1,
    record: Annotated[bool, typer.Option("--record/--no-record", help="Keep the verdict in the project.")] = True,
    as_json: AsJson = False,
) -> None:
    """Compute every run again from its recorded inputs and settings, and compare every number.

    Bit by bit where software and processor are those of the run, else to 1e-9. A second engine solves each adjustment;
    OpenCV and PoseLib check poses where they are installed: pip install 'orient[engines]'.
    """
    from orient.pipeline.verify import Request
    from orient.report.verify import show_verify

    show_verify(project, Request(simulate, seed, record, message), as_json)
