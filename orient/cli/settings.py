"""Settings of the stages as options of the commands, and what they mean when they are given."""

import math
from typing import Annotated

import typer
from typer.models import OptionInfo

from orient.cli.completion import from_words
from orient.cli.options import valid_text
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


def settings_of(**options: str | int | float | bool | None) -> Settings:
    return {name: value for name, value in options.items() if value is not None}


def exclusion(exclude: list[str] | None, reason: list[str] | None) -> Settings:
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


def degree_of(value: str) -> int | None:
    """`auto` is the choice by test, also where an earlier version was told a degree."""
    if value == "auto":
        return None
    if value not in ("1", "2", "3", "4", "5"):
        raise typer.BadParameter(f"{value!r} is not auto or one of 1, 2, 3, 4, 5.")
    return int(value)


def sigma_of(value: str) -> float | None:
    """`none` takes the model as errorless again, also where an earlier version was told a sigma."""
    if value == "none":
        return None
    sigma = float(value) if NUMBER.fullmatch(value) else math.nan
    if not (SMALLEST_SIGMA <= sigma <= LARGEST_SIGMA):
        raise typer.BadParameter(f"{value!r} is not none or a number between {SMALLEST_SIGMA} and {LARGEST_SIGMA:g}.")
    return sigma


def _small(value: float | None) -> float | None:
    if value is not None and not (math.isfinite(value) and 0 < value <= LARGEST_TOLERANCE):
        raise typer.BadParameter(f"{value} is not between 0 and {LARGEST_TOLERANCE}.")
    return value


def _height_sigma(value: float | None) -> float | None:
    if value is not None and not (math.isfinite(value) and 0 <= value <= LARGEST_SIGMA):
        raise typer.BadParameter(f"{value} is not between 0 and {LARGEST_SIGMA:g} m.")
    return value


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
Pairs = Annotated[bool | None, typer.Option("--pairs/--no-pairs", help="Also between all pairs of points.")]
MapSide = Annotated[
    int | None,
    typer.Option(
        "--map-side",
        min=MAP_SIDES[0],
        max=MAP_SIDES[1],
        help="Places along each side of the frame in the map of accuracy.",
    ),
]
MapHeightSigma = Annotated[
    float | None,
    typer.Option("--map-height-sigma-m", callback=_height_sigma, help="Sigma of the heights that the map takes."),
]
SigmaModel = Annotated[
    str | None,
    typer.Option(
        "--sigma-model",
        metavar="NUMBER|none",
        help="Standard deviation of a model coordinate, in model units, where model.csv gives none.",
    ),
]
UpsideDown = Annotated[
    bool | None,
    typer.Option("--upside-down/--upright", help="The model's Z axis may point down on the ground."),
]
SmallAngles = Annotated[
    bool | None,
    typer.Option("--small-angles/--no-small-angles", help="Also the small-angle formulas, beside the rigorous."),
]
