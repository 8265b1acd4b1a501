"""Commands that compute: run, and one for each stage."""

import math
from pathlib import Path
from typing import Annotated

import typer
from typer.models import OptionInfo

from orient.cli.completion import from_words
from orient.cli.options import Again, ProjectPath, Reason, valid_text
from orient.errors import UsageError
from orient.pipeline.setting_values import (
    CAMERA_ELEMENTS,
    LARGEST_SIGMA,
    LARGEST_TOLERANCE,
    MAP_SIDES,
    MOST_ITERATIONS,
    SMALLEST_SIGMA,
    WORDS,
)
from orient.units import NUMBER
from orient.values import Settings


def register(app: typer.Typer) -> None:
    app.command()(run)
    for command in (refine, digitize, bl, topocentric, resection, covariance, absolute):
        app.command(epilog=STICKY)(command)


STICKY = (
    "Settings hold for the next versions too. --defaults takes all of them back; single ones go back by the word "
    "behind the slash (--keep, --plain), by none or auto. An older version is made current by: orient select."
)


Exclude = Annotated[
    list[str] | None,
    typer.Option(
        "--exclude",
        metavar="P7,P9|none",
        help="Leave these out; needs --reason. May be given again. none: take all points again.",
    ),
]
Why = Annotated[
    list[str] | None,
    typer.Option("--reason", metavar="TEXT", help="Why they are left out; it is kept with each of them."),
]
Robust = Annotated[
    bool | None,
    typer.Option(
        "--robust/--plain", help="First find the points that agree; the result is a plain adjustment of them."
    ),
]


def _exclusion(exclude: list[str] | None, reason: list[str] | None) -> Settings:
    """`none` takes all points again, whoever left them out; a point is left out with a reason only.

    What the same command says of --reject and --robust counts more: write it behind this. Options given again add up.
    """
    names, why = ",".join(exclude or ()), "; ".join(reason or ())
    if not exclude:
        if reason:
            raise UsageError("--reason belongs to --exclude", "Say which points: --exclude P7,P9 --reason TEXT")
        return {}
    if names.strip() in ("", "none"):
        return {"exclude": "", "exclude_reason": "", "reject": False, "robust": False}
    if not why.strip("; "):
        raise UsageError("say why the points are left out", '--exclude P7 --reason "wrong house"')
    return {"exclude": valid_text(names), "exclude_reason": valid_text(why)}


def _small(value: float | None) -> float | None:
    if value is not None and not (math.isfinite(value) and 0 < value <= LARGEST_TOLERANCE):
        raise typer.BadParameter(f"{value} is not between 0 and {LARGEST_TOLERANCE}.")
    return value


def _height_sigma(value: float | None) -> float | None:
    if value is not None and not (math.isfinite(value) and 0 <= value <= LARGEST_SIGMA):
        raise typer.BadParameter(f"{value} is not between 0 and {LARGEST_SIGMA:g} m.")
    return value


def _degree(value: str) -> int | None:
    """`auto` is the choice by test, also where an earlier version was told a degree."""
    if value == "auto":
        return None
    if value not in ("1", "2", "3", "4", "5"):
        raise typer.BadParameter(f"{value!r} is not auto or one of 1, 2, 3, 4, 5.")
    return int(value)


def _sigma(value: str) -> float | None:
    """`none` takes the model as errorless again, also where an earlier version was told a sigma."""
    if value == "none":
        return None
    sigma = float(value) if NUMBER.fullmatch(value) else math.nan
    if not (SMALLEST_SIGMA <= sigma <= LARGEST_SIGMA):
        raise typer.BadParameter(f"{value!r} is not none or a number between {SMALLEST_SIGMA} and {LARGEST_SIGMA:g}.")
    return sigma


def _choice(name: str, words: tuple[str, ...], help_text: str) -> OptionInfo:
    """An option that takes one of some words."""

    def check(value: str | None) -> str | None:
        if value is not None and value not in words:
            raise typer.BadParameter(f"{value!r} is not one of {', '.join(words)}.")
        return value

    option: OptionInfo = typer.Option(
        name, metavar="|".join(words), callback=check, autocompletion=from_words(words), help=help_text
    )
    return option


def _elements(value: str | None) -> str | None:
    """`f,k1` in the order of the columns; `none` takes the camera as known again."""
    if value is None or value == "none":
        return value
    names = [name.strip() for name in value.split(",")]
    for name in names:
        if name not in CAMERA_ELEMENTS:
            raise typer.BadParameter(f"{name!r} is not none or a list of {', '.join(CAMERA_ELEMENTS)}.")
    return ",".join(name for name in CAMERA_ELEMENTS if name in names)


Reject = Annotated[
    bool | None,
    typer.Option("--reject/--keep", help="Leave flagged readings, crosses or points out; each is recorded."),
]
AllowBallpark = Annotated[
    bool | None,
    typer.Option("--allow-ballpark/--no-ballpark", help="Accept a datum change that is unknown or lacks its grid."),
]


Engine = Annotated[str | None, _choice("--engine", WORDS["engine"], "Algorithm Z (normal equations), or QR.")]
Degree = Annotated[
    str | None, typer.Option("--degree", metavar="1...5|auto", help="Degree of the polynomial; auto: chosen.")
]
Choice = Annotated[str | None, _choice("--choice", WORDS["choice"], "What chooses a degree that is not given.")]
Radius = Annotated[
    str | None, _choice("--radius", WORDS["radius"], "N exact, or by the paper's polynomial (Krasovsky only).")
]
Control = Annotated[str | None, _choice("--control", WORDS["control"], "Errors of the control: as given, none, all.")]
Correlation = Annotated[
    str | None,
    _choice("--correlation", WORDS["correlation"], "Errors of a map sheet: common to its points, or each point apart."),
]
Interior = Annotated[
    str | None,
    _choice("--interior", WORDS["interior"], "Interior orientation: as sure as its fiducial marks, or known."),
]
Test = Annotated[
    str | None,
    _choice("--test", WORDS["test"], "Baarda's w (sigma0 known), Pope's tau (estimated); auto follows --variance."),
]
Variance = Annotated[str | None, _choice("--variance", WORDS["variance"], "Which sigma0 scales the covariances.")]
MaxIterations = Annotated[int | None, typer.Option("--max-iterations", min=1, max=MOST_ITERATIONS)]
Estimate = Annotated[
    str | None,
    typer.Option(
        "--estimate",
        metavar="f,x0,y0,k1,k2,k3,p1,p2,b1,b2|none",
        callback=_elements,
        help="Elements of the camera that are unknown too, held by their sigmas in photo.toml.",
    ),
]
FreeCamera = Annotated[
    bool | None,
    typer.Option("--free-camera/--camera-priors", help="Estimate without, or with the sigmas of photo.toml."),
]
CameraUse = Annotated[
    str | None, _choice("--camera", WORDS["camera"], "Camera as known, or with the sigmas of photo.toml.")
]
Calibrate = Annotated[
    str | None,
    _choice("--calibrate", WORDS["calibrate"], "Add elements of the camera by steps while significant and separable."),
]
LensDirection = Annotated[
    str | None,
    _choice(
        "--distortion",
        WORDS["distortion"],
        "Direction of k1 ... p2 where photo.toml has no lens; camera: correction.",
    ),
]
Tolerance = Annotated[
    float | None,
    typer.Option("--tolerance", callback=_small, help="Largest scaled step that counts as converged."),
]
Defaults = Annotated[
    bool, typer.Option("--defaults", help="Begin from the defaults, not from the settings of the current version.")
]
Pairs = Annotated[bool | None, typer.Option("--pairs/--no-pairs", help="Also between all pairs of points.")]


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
    asked = {} if degree is None else {"degree": _degree(degree)}
    given = settings_of(choice=choice, engine=engine, reject=reject, robust=robust)
    _stage(project, "digitize", {**_exclusion(exclude, reason), **given, **asked}, message, again, defaults)


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
    _stage(project, "resection", {**_exclusion(exclude, reason), **given}, message, again, defaults)


def covariance(
    project: ProjectPath,
    message: Reason = "covariance",
    again: Again = False,
    defaults: Defaults = False,
    pairs: Pairs = None,
    map_side: Annotated[
        int | None,
        typer.Option(
            "--map-side",
            min=MAP_SIDES[0],
            max=MAP_SIDES[1],
            help="Places along each side of the frame in the map of accuracy.",
        ),
    ] = None,
    map_height_sigma_m: Annotated[
        float | None,
        typer.Option("--map-height-sigma-m", callback=_height_sigma, help="Sigma of the heights that the map takes."),
    ] = None,
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
    sigma_model: Annotated[
        str | None,
        typer.Option(
            "--sigma-model",
            metavar="NUMBER|none",
            help="Standard deviation of a model coordinate, in model units, where model.csv gives none.",
        ),
    ] = None,
    upside_down: Annotated[
        bool | None,
        typer.Option("--upside-down/--upright", help="The model's Z axis may point down on the ground."),
    ] = None,
    small_angles: Annotated[
        bool | None,
        typer.Option("--small-angles/--no-small-angles", help="Also the small-angle formulas, beside the rigorous."),
    ] = None,
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
    asked = {} if sigma_model is None else {"sigma_model": _sigma(sigma_model)}
    _stage(project, "absolute", {**_exclusion(exclude, reason), **given, **asked}, message, again, defaults)


def settings_of(**options: str | int | float | bool | None) -> Settings:
    return {name: value for name, value in options.items() if value is not None}


def _stage(project: Path, name: str, settings: Settings, message: str, again: bool, defaults: bool) -> None:
    from orient.pipeline.runner import run_stage
    from orient.report.runs import show_result

    show_result(run_stage(project, name, settings, message, again, defaults), project)
