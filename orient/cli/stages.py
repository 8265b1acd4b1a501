"""Commands that compute: run, and one for each stage."""

from pathlib import Path
from typing import Annotated

import typer

from orient.cli.options import Again, ProjectPath, Reason
from orient.cli.settings import (
    AllowBallpark,
    Calibrate,
    CameraUse,
    Choice,
    Control,
    Correlation,
    Degree,
    Engine,
    Estimate,
    Exclude,
    FreeCamera,
    Interior,
    LensDirection,
    MapHeightSigma,
    MapSide,
    MaxIterations,
    Pairs,
    Radius,
    Reject,
    Robust,
    SigmaModel,
    SmallAngles,
    Test,
    Tolerance,
    UpsideDown,
    Variance,
    Why,
    degree_of,
    exclusion,
    settings_of,
    sigma_of,
)
from orient.values import Settings

STICKY = (
    "Settings hold for the next versions too. --defaults takes all of them back; single ones go back by the word "
    "behind the slash (--keep, --plain), by none or auto. An older version is made current by: orient select."
)
Defaults = Annotated[
    bool, typer.Option("--defaults", help="Begin from the defaults, not from the settings of the current version.")
]


def register(app: typer.Typer) -> None:
    app.command()(run)
    for command in (refine, digitize, bl, topocentric, resection, covariance, absolute):
        app.command(epilog=STICKY)(command)


def run(
    project: ProjectPath,
    message: Reason = "run",
    allow_ballpark: AllowBallpark = None,
) -> None:
    """Compute everything that is missing or stale, in order. Settings of the current versions are kept."""
    from orient.pipeline.runner import run_stale
    from orient.report.runs import Progress

    with Progress() as progress:
        results = run_stale(project, settings_of(allow_ballpark=allow_ballpark), message, progress.begin, progress.end)
    progress.close_with(results, project)


def refine(
    project: ProjectPath,
    message: Reason = "refine",
    again: Again = False,
    defaults: Defaults = False,
    engine: Engine = None,
    reject: Reject = None,
) -> None:
    """Image coordinates: cycle means, interior orientation, distortion, refraction, curvature."""
    _stage(project, "refine", settings_of(engine=engine, reject=reject), message, again, defaults)


def digitize(
    project: ProjectPath,
    message: Reason = "digitize",
    again: Again = False,
    defaults: Defaults = False,
    degree: Degree = None,
    choice: Choice = None,
    engine: Engine = None,
    reject: Reject = None,
    robust: Robust = None,
    exclude: Exclude = None,
    reason: Why = None,
) -> None:
    """Map points by the polynomial of their sheet, with covariance; bad crosses are named."""
    asked = {} if degree is None else {"degree": degree_of(degree)}
    given = settings_of(choice=choice, engine=engine, reject=reject, robust=robust)
    _stage(project, "digitize", {**exclusion(exclude, reason), **given, **asked}, message, again, defaults)


def bl(
    project: ProjectPath,
    message: Reason = "bl",
    again: Again = False,
    defaults: Defaults = False,
    allow_ballpark: AllowBallpark = None,
) -> None:
    """B, L, H of all points on the ground's ellipsoid; the datum change is recorded."""
    _stage(project, "bl", settings_of(allow_ballpark=allow_ballpark), message, again, defaults)


def topocentric(
    project: ProjectPath,
    message: Reason = "topocentric",
    again: Again = False,
    defaults: Defaults = False,
    radius: Radius = None,
) -> None:
    """Topocentric coordinates T and T' of all points."""
    _stage(project, "topocentric", settings_of(radius=radius), message, again, defaults)


def resection(
    project: ProjectPath,
    message: Reason = "resection",
    again: Again = False,
    defaults: Defaults = False,
    control: Control = None,
    correlation: Correlation = None,
    interior: Interior = None,
    variance: Variance = None,
    engine: Engine = None,
    estimate: Estimate = None,
    free_camera: FreeCamera = None,
    camera: CameraUse = None,
    calibrate: Calibrate = None,
    distortion: LensDirection = None,
    test: Test = None,
    reject: Reject = None,
    robust: Robust = None,
    exclude: Exclude = None,
    reason: Why = None,
    max_iterations: MaxIterations = None,
    tolerance: Tolerance = None,
) -> None:
    """Exterior orientation of the photo, and of its camera if asked; no approximate values are needed."""
    given = settings_of(
        estimate=estimate,
        free_camera=free_camera,
        camera=camera,
        calibrate=calibrate,
        distortion=distortion,
        control=control,
        correlation=correlation,
        interior=interior,
        variance=variance,
        engine=engine,
        test=test,
        reject=reject,
        robust=robust,
        max_iterations=max_iterations,
        tolerance=tolerance,
    )
    _stage(project, "resection", {**exclusion(exclude, reason), **given}, message, again, defaults)


def covariance(
    project: ProjectPath,
    message: Reason = "covariance",
    again: Again = False,
    defaults: Defaults = False,
    pairs: Pairs = None,
    map_side: MapSide = None,
    map_height_sigma_m: MapHeightSigma = None,
) -> None:
    """Covariance of the ground points, K = C Q C', error ellipses, and a map of the accuracy over the frame."""
    given = settings_of(pairs=pairs, map_side=map_side, map_height_sigma_m=map_height_sigma_m)
    _stage(project, "covariance", given, message, again, defaults)


def absolute(
    project: ProjectPath,
    message: Reason = "absolute",
    again: Again = False,
    defaults: Defaults = False,
    control: Control = None,
    sigma_model: SigmaModel = None,
    upside_down: UpsideDown = None,
    small_angles: SmallAngles = None,
    variance: Variance = None,
    engine: Engine = None,
    test: Test = None,
    reject: Reject = None,
    robust: Robust = None,
    exclude: Exclude = None,
    reason: Why = None,
    max_iterations: MaxIterations = None,
    tolerance: Tolerance = None,
) -> None:
    """Absolute orientation of a model, zone by zone; all its points on the ground."""
    given = settings_of(
        control=control,
        upside_down=upside_down,
        small_angles=small_angles,
        variance=variance,
        engine=engine,
        test=test,
        reject=reject,
        robust=robust,
        max_iterations=max_iterations,
        tolerance=tolerance,
    )
    asked = {} if sigma_model is None else {"sigma_model": sigma_of(sigma_model)}
    _stage(project, "absolute", {**exclusion(exclude, reason), **given, **asked}, message, again, defaults)


def _stage(project: Path, name: str, settings: Settings, message: str, again: bool, defaults: bool) -> None:
    from orient.pipeline.runner import run_stage
    from orient.report.runs import show_result

    show_result(run_stage(project, name, settings, message, again, defaults), project)
