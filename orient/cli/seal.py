"""Commands about the file to send: seal, and image, which gets the photo's image out again."""

from pathlib import Path
from typing import Annotated

import typer

from orient.cli.options import AsJson, Force, ProjectPath, Reason


def register(app: typer.Typer) -> None:
    for command in (seal, image):
        app.command()(command)


def seal(
    project: ProjectPath,
    output: Annotated[str, typer.Option("--output", "-o", metavar="SEALED", help="The file to send; a new name.")],
    image_file: Annotated[
        Path | None, typer.Option("--image", metavar="FILE", help="The photo's image, put into the file.")
    ] = None,
    reference: Annotated[
        bool, typer.Option("--reference", help="Only name, size and SHA-256 of the image, not its bytes.")
    ] = False,
    message: Reason = "sealed",
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Make one file to send: a compacted, verified copy with the photo's image and a manifest of all it holds.

    It is a project as any other. The project itself is only read.
    """
    from orient.pipeline.seal import Request
    from orient.report.seal import show_sealed

    show_sealed(project, output, Request(image_file, reference, message, force), as_json)


def image(
    project: ProjectPath,
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FILE|-", help="Write the image to this file; - is the output.")
    ] = "",
    compare: Annotated[
        Path | None, typer.Option("--compare", metavar="FILE", help="Tell whether this file is the image.")
    ] = None,
    force: Force = False,
) -> None:
    """What is known of the photo's image; with -o, the image itself, its SHA-256 verified."""
    from orient.report.seal import show_image

    show_image(project, output, compare, force)
