"""The command `export`: the current orientation for another program."""

from typing import Annotated

import typer

from orient.cli.completion import format_names
from orient.cli.options import Force, ProjectPath, valid_text

LARGEST_PIXEL_MM, LARGEST_MAGNIFICATION = 10.0, 1e9


def register(app: typer.Typer) -> None:
    app.command()(export)


def _positive(value: float | None, most: float) -> float | None:
    if value is not None and not 0 < value <= most:  # also refuses nan
        raise typer.BadParameter(f"{value} is not a number above 0, at most {most:g}.")
    return value


def export(
    project: ProjectPath,
    format_name: Annotated[
        str,
        typer.Argument(
            metavar="FORMAT",
            autocompletion=format_names,
            callback=valid_text,
            help="geojson, gpkg, opencv, opk, elements, residuals or points.",
        ),
    ],
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FILE|-", help="Its ending must be one of the format's; - prints.")
    ],
    force: Force = False,
    crs: Annotated[
        str, typer.Option("--crs", metavar="EPSG:...", callback=valid_text, help="gpkg: instead of the map's own.")
    ] = "",
    allow_ballpark: Annotated[
        bool, typer.Option("--allow-ballpark", help="geojson, gpkg: accept a datum change that is not known.")
    ] = False,
    magnify: Annotated[
        float | None,
        typer.Option(
            "--magnify",
            metavar="N",
            callback=lambda value: _positive(value, LARGEST_MAGNIFICATION),
            help="geojson, gpkg: residual vectors and ellipses N times their size; 1 is true to scale.",
        ),
    ] = None,
    pixel_mm: Annotated[
        float | None,
        typer.Option(
            "--pixel-mm",
            metavar="SIZE",
            callback=lambda value: _positive(value, LARGEST_PIXEL_MM),
            help="opencv: size of a virtual pixel where the photo has none of its own.",
        ),
    ] = None,
) -> None:
    """Write the orientation with its 6 x 6 covariance for QGIS, OpenCV or a spreadsheet.

    geojson and gpkg hold layers of control, check points, residuals, ellipses, footprint and station; opencv holds
    rvec, tvec, K, dist and the control; opk, elements, residuals and points are CSV, with FILE-metadata.json beside
    them. gpkg needs orient[gis].
    """
    import sys

    from orient.errors import UsageError
    from orient.export import Options, format_named, make
    from orient.report.output_file import STDOUT, ending_of, output_path, write_output

    form = format_named(format_name)
    options = Options(crs, allow_ballpark, magnify, pixel_mm)
    if output == STDOUT:
        if not form.is_text:
            raise UsageError(f"{form.name} cannot be printed", f"Give a file: -o FILE{form.endings[0]}")
        for piece in make(project, form, form.endings[0], f"{form.name}{form.endings[0]}", options).content:
            sys.stdout.write(piece.decode("utf-8"))
        return
    ending = ending_of(output, form.endings, f"file for {form.name}")
    target = output_path(output, project, force)
    made = make(project, form, ending, target.name, options)
    for extra, content in made.beside.items():
        write_output(output_path(f"{output}{extra}", project, force), content, project, force)
    write_output(target, made.content, project, force)
