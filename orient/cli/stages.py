"""Commands that compute: run, and one for each stage."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from orient.cli.options import Again, ProjectPath, Reason
from orient.values import Settings

CONTROL = ("auto", "fixed", "weighted")
CORRELATION = ("sheet", "point")
INTERIOR = ("weighted", "fixed")
ENGINE = ("zlatanov", "qr")
VARIANCE = ("posteriori", "priori")
CHOICE = ("f-test", "leave-one-out")
RADIUS = ("exact", "polynomial")


def register(app: typer.Typer) -> None:
    for command in (run, refine, digitize, bl, topocentric, resection, covariance):
        app.command()(command)


LARGEST_TOLERANCE = 1e-4
LARGEST_SIGMA_M = 1e8

Reject = Annotated[
    bool | None, typer.Option("--reject/--keep", help="Leave flagged readings or crosses out; each is recorded.")
]
AllowBallpark = Annotated[
    bool | None,
    typer.Option("--allow-ballpark/--no-ballpark", help="Accept a datum change that is unknown or lacks its grid."),
]


def _one_of(words: tuple[str, ...]) -> Callable[[str | None], str | None]:
    def check(value: str | None) -> str | None:
        if value is not None and value not in words:
            raise typer.BadParameter(f"{value!r} is not one of {', '.join(words)}.")
        return value

    return check


def _small(value: float | None) -> float | None:
    if value is not None and not (math.isfinite(value) and 0 < value <= LARGEST_TOLERANCE):
        raise typer.BadParameter(f"{value} is not between 0 and {LARGEST_TOLERANCE}.")
    return value


def _sigma(value: float | None) -> float | None:
    if value is not None and not (math.isfinite(value) and 0 <= value <= LARGEST_SIGMA_M):
        raise typer.BadParameter(f"{value} is not between 0 and {LARGEST_SIGMA_M:g} m.")
    return value


def _degree(value: str) -> int | None:
    """`auto` is the choice by test, also where an earlier version was told a degree."""
    if value == "auto":
        return None
    if value not in ("1", "2", "3", "4", "5"):
        raise typer.BadParameter(f"{value!r} is not auto or one of 1, 2, 3, 4, 5.")
    return int(value)


Tolerance = Annotated[
    float | None,
    typer.Option("--tolerance", callback=_small, help="Largest scaled step that counts as converged."),
]


def run(
    project: ProjectPath,
    message: Reason = "run",
    allow_ballpark: AllowBallpark = None,
) -> None:
    """Compute everything that is missing or stale, in order. Settings of the current versions are kept."""
    from orient.pipeline.runner import run_stale
    from orient.report.runs import Progress

    with Progress() as progress:
        results = run_stale(project, _given(allow_ballpark=allow_ballpark), message, progress.begin, progress.end)
    progress.close_with(results, project)


def refine(project: ProjectPath, message: Reason = "refine", again: Again = False, reject: Reject = None) -> None:
    """Image coordinates: cycle means, interior orientation, distortion, refraction, curvature."""
    _stage(project, "refine", _given(reject=reject), message, again)


def digitize(
    project: ProjectPath,
    message: Reason = "digitize",
    again: Again = False,
    degree: Annotated[
        str | None, typer.Option("--degree", metavar="1...5|auto", help="Degree of the polynomial; auto: chosen.")
    ] = None,
    choice: Annotated[
        str | None,
        typer.Option(
            "--choice",
            metavar="|".join(CHOICE),
            callback=_one_of(CHOICE),
            help="What chooses a degree that is not given.",
        ),
    ] = None,
    reject: Reject = None,
) -> None:
    """Map points by the polynomial of their sheet, with covariance; bad crosses are named."""
    asked = {} if degree is None else {"degree": _degree(degree)}
    _stage(project, "digitize", {**_given(choice=choice, reject=reject), **asked}, message, again)


def bl(
    project: ProjectPath, message: Reason = "bl", again: Again = False, allow_ballpark: AllowBallpark = None
) -> None:
    """B, L, H of all points on the ground's ellipsoid; the datum change is recorded."""
    _stage(project, "bl", _given(allow_ballpark=allow_ballpark), message, again)


def topocentric(
    project: ProjectPath,
    message: Reason = "topocentric",
    again: Again = False,
    radius: Annotated[
        str | None,
        typer.Option(
            "--radius",
            metavar="|".join(RADIUS),
            callback=_one_of(RADIUS),
            help="N exact, or by the paper's polynomial (Krasovsky only).",
        ),
    ] = None,
) -> None:
    """Topocentric coordinates T and T' of all points."""
    _stage(project, "topocentric", _given(radius=radius), message, again)


def resection(
    project: ProjectPath,
    message: Reason = "resection",
    again: Again = False,
    control: Annotated[
        str | None,
        typer.Option(
            "--control",
            metavar="|".join(CONTROL),
            callback=_one_of(CONTROL),
            help="Errors of the control: as given, none, all.",
        ),
    ] = None,
    correlation: Annotated[
        str | None,
        typer.Option(
            "--correlation",
            metavar="|".join(CORRELATION),
            callback=_one_of(CORRELATION),
            help="Errors of a map sheet: common to its points, or each point apart.",
        ),
    ] = None,
    interior: Annotated[
        str | None,
        typer.Option(
            "--interior",
            metavar="|".join(INTERIOR),
            callback=_one_of(INTERIOR),
            help="Interior orientation: as sure as its fiducial marks, or known.",
        ),
    ] = None,
    variance: Annotated[
        str | None,
        typer.Option(
            "--variance",
            metavar="|".join(VARIANCE),
            callback=_one_of(VARIANCE),
            help="Which sigma0 scales the covariances.",
        ),
    ] = None,
    engine: Annotated[
        str | None,
        typer.Option(
            "--engine",
            metavar="|".join(ENGINE),
            callback=_one_of(ENGINE),
            help="Algorithm Z polished by QR, or QR alone.",
        ),
    ] = None,
    max_iterations: Annotated[int | None, typer.Option("--max-iterations", min=1, max=1000)] = None,
    tolerance: Tolerance = None,
) -> None:
    """Exterior orientation of the photo; no approximate values are needed."""
    given = _given(
        control=control,
        correlation=correlation,
        interior=interior,
        variance=variance,
        engine=engine,
        max_iterations=max_iterations,
        tolerance=tolerance,
    )
    _stage(project, "resection", given, message, again)


def covariance(
    project: ProjectPath,
    message: Reason = "covariance",
    again: Again = False,
    pairs: Annotated[bool | None, typer.Option("--pairs/--no-pairs", help="Also between all pairs of points.")] = None,
    map_side: Annotated[
        int | None,
        typer.Option("--map-side", min=2, max=101, help="Places along each side of the frame in the map of accuracy."),
    ] = None,
    map_height_sigma_m: Annotated[
        float | None,
        typer.Option("--map-height-sigma-m", callback=_sigma, help="Sigma of the heights that the map takes."),
    ] = None,
) -> None:
    """Covariance of the ground points, K = C Q C', error ellipses, and a map of the accuracy over the frame."""
    given = _given(pairs=pairs, map_side=map_side, map_height_sigma_m=map_height_sigma_m)
    _stage(project, "covariance", given, message, again)


def _given(**options: str | int | float | bool | None) -> Settings:
    return {name: value for name, value in options.items() if value is not None}


def _stage(project: Path, name: str, settings: Settings, message: str, again: bool) -> None:
    from orient.pipeline.runner import run_stage
    from orient.report.runs import show_result

    show_result(run_stage(project, name, settings, message, again), project)
