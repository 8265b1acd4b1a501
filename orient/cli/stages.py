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
ENGINE = ("zlatanov", "qr")
VARIANCE = ("posteriori", "priori")
CALIBRATE = ("none", "auto")
CAMERA = ("fixed", "weighted")
DISTORTION = ("camera", "correction", "displacement", "ideal_to_distorted")
CAMERA_ELEMENTS = ("f", "x0", "y0", "k1", "k2", "k3", "p1", "p2", "b1", "b2")
CHOICE = ("f-test", "leave-one-out")
RADIUS = ("exact", "polynomial")


def register(app: typer.Typer) -> None:
    for command in (run, refine, digitize, bl, topocentric, resection, covariance):
        app.command()(command)


LARGEST_TOLERANCE = 1e-4

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


def _degree(value: str) -> int | None:
    """`auto` is the choice by test, also where an earlier version was told a degree."""
    if value == "auto":
        return None
    if value not in ("1", "2", "3", "4", "5"):
        raise typer.BadParameter(f"{value!r} is not auto or one of 1, 2, 3, 4, 5.")
    return int(value)


def _elements(value: str | None) -> str | None:
    """`f,k1` in the order of the columns; `none` takes the camera as known again."""
    if value is None or value == "none":
        return value
    names = [name.strip() for name in value.split(",")]
    for name in names:
        if name not in CAMERA_ELEMENTS:
            raise typer.BadParameter(f"{name!r} is not none or a list of {', '.join(CAMERA_ELEMENTS)}.")
    return ",".join(name for name in CAMERA_ELEMENTS if name in names)


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
    estimate: Annotated[
        str | None,
        typer.Option(
            "--estimate",
            metavar="f,x0,y0,k1,k2,k3,p1,p2,b1,b2|none",
            callback=_elements,
            help="Elements of the camera that are unknown too, held by their sigmas in photo.toml.",
        ),
    ] = None,
    free_camera: Annotated[
        bool | None,
        typer.Option("--free-camera/--camera-priors", help="Estimate without, or with the sigmas of photo.toml."),
    ] = None,
    camera: Annotated[
        str | None,
        typer.Option(
            "--camera",
            metavar="|".join(CAMERA),
            callback=_one_of(CAMERA),
            help="Camera as known, or with the sigmas of photo.toml.",
        ),
    ] = None,
    calibrate: Annotated[
        str | None,
        typer.Option(
            "--calibrate",
            metavar="|".join(CALIBRATE),
            callback=_one_of(CALIBRATE),
            help="Add elements of the camera by steps while significant and separable.",
        ),
    ] = None,
    distortion: Annotated[
        str | None,
        typer.Option(
            "--distortion",
            metavar="|".join(DISTORTION),
            callback=_one_of(DISTORTION),
            help="Direction of k1 ... p2 where photo.toml has no lens; camera: correction.",
        ),
    ] = None,
    max_iterations: Annotated[int | None, typer.Option("--max-iterations", min=1, max=1000)] = None,
    tolerance: Tolerance = None,
) -> None:
    """Exterior orientation of the photo, and of its camera if asked; no approximate values are needed."""
    given = _given(
        estimate=estimate,
        free_camera=free_camera,
        camera=camera,
        calibrate=calibrate,
        distortion=distortion,
        control=control,
        correlation=correlation,
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
) -> None:
    """Covariance of the ground points, K = C Q C', and error ellipses."""
    _stage(project, "covariance", _given(pairs=pairs), message, again)


def _given(**options: str | int | float | bool | None) -> Settings:
    return {name: value for name, value in options.items() if value is not None}


def _stage(project: Path, name: str, settings: Settings, message: str, again: bool) -> None:
    from orient.pipeline.runner import run_stage
    from orient.report.runs import show_result

    show_result(run_stage(project, name, settings, message, again), project)
