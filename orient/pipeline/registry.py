"""The stages: what each one reads, in which order they run, and their settings. Imports no mathematics."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Protocol, cast

from orient.values import Outcome, Settings, Tables

EVIDENCE = "verify"
MANIFEST = "seal"
IMAGE = "image"
"""The image file of the photo: versions as of a list, but no stage reads it."""
ABOUT_RUNS = (EVIDENCE, MANIFEST)
"""Stages whose runs are about other runs: they have no current version and nothing reads them."""
REMEDY = "remedy"
"""Code of the event of a failed run that says what to do about it."""
INPUT_STAGES = ("photo", "readings", "sheet", "control", "model")


class Compute(Protocol):
    def __call__(self, inputs: Mapping[str, Tables], settings: Settings) -> Outcome: ...


@dataclass(frozen=True, slots=True)
class Stage:
    """One computed stage. `version` rises when the computation changes in a way that can change a number.

    Settings of the current version hold for the next one too, but for `not_kept`: a consent is given once.
    `wanted_with` is the list that a user adds because of this stage: without it nothing is missing.
    `formerly`: what versions were made with before a setting existed. Such a version stays what it is, current and
    fresh, and its successor is made in the same way unless the user says otherwise.
    """

    name: str
    version: int
    title: str
    required: tuple[str, ...]
    optional: tuple[str, ...] = ()
    needs_one_of: tuple[str, ...] = ()
    settings: Mapping[str, str | int | float | bool | None] = field(default_factory=dict)
    not_kept: tuple[str, ...] = ()
    wanted_with: str = ""
    formerly: Mapping[str, str | int | float | bool | None] = field(default_factory=dict)

    @property
    def inputs(self) -> tuple[str, ...]:
        return self.required + self.optional

    def missing(self, available: set[str]) -> str:
        """What the stage still waits for, in words; empty when it can run."""
        absent = [name for name in self.required if name not in available]
        if self.needs_one_of and not available.intersection(self.needs_one_of):
            absent.append(" or ".join(self.needs_one_of))
        return ", ".join(absent)

    def compute(self, inputs: Mapping[str, Tables], settings: Settings) -> Outcome:
        module = import_module(f"orient.pipeline.{self.name}")
        return cast(Compute, module.compute)(inputs, settings)


STAGES = (
    Stage(
        "refine",
        2,
        "image coordinates: cycle means, interior orientation, distortion, refraction, curvature",
        required=("photo", "readings"),
        settings={"engine": "zlatanov", "reject": False},
        formerly={"engine": "qr"},
    ),
    Stage(
        "digitize",
        2,
        "map points: polynomial of each sheet",
        required=("photo", "sheet"),
        settings={
            "engine": "zlatanov",
            "degree": None,
            "choice": "f-test",
            "reject": False,
            "robust": False,
            "exclude": "",
            "exclude_reason": "",
        },
        formerly={"engine": "qr"},
    ),
    Stage(
        "bl",
        2,
        "B, L, H of the points on the ground's ellipsoid",
        required=("photo",),
        optional=("control", "digitize"),
        needs_one_of=("control", "digitize"),
        settings={"allow_ballpark": False},
        not_kept=("allow_ballpark",),
    ),
    Stage(
        "topocentric",
        2,
        "topocentric coordinates T and T'",
        required=("photo", "bl"),
        settings={"radius": "exact"},
    ),
    Stage(
        "resection",
        6,
        "exterior orientation",
        required=("photo", "refine", "topocentric"),
        optional=("digitize",),
        settings={
            "engine": "zlatanov",
            "control": "auto",
            "correlation": "sheet",
            "interior": "weighted",
            "variance": "posteriori",
            "estimate": "none",
            "calibrate": "none",
            "camera": "fixed",
            "free_camera": False,
            "distortion": "camera",
            "max_iterations": 50,
            "tolerance": 1e-10,
            "test": "auto",
            "reject": False,
            "robust": False,
            "exclude": "",
            "exclude_reason": "",
        },
    ),
    Stage(
        "covariance",
        6,
        "covariance of ground points, K = C Q C'",
        required=("photo", "refine", "topocentric", "resection"),
        settings={"pairs": False, "map_side": 11, "map_height_sigma_m": 0.0},
    ),
    Stage(
        "absolute",
        3,
        "absolute orientation of a model, by zone",
        required=("photo", "model", "topocentric"),
        settings={
            "engine": "zlatanov",
            "control": "auto",
            "variance": "posteriori",
            "sigma_model": None,
            "upside_down": False,
            "small_angles": False,
            "max_iterations": 50,
            "tolerance": 1e-10,
            "test": "auto",
            "reject": False,
            "robust": False,
            "exclude": "",
            "exclude_reason": "",
        },
        wanted_with="model",
    ),
)
BY_NAME = {stage.name: stage for stage in STAGES}
ALL_STAGES = INPUT_STAGES + tuple(BY_NAME)


EVIDENCE_TABLES = (
    "cycle_residual", "iteration_parameter", "equation", "camera_equation", "observation_test", "point_test",
    "external_reliability",
)  # fmt: skip
"""Large tables that no stage reads: they prove a result, and nothing is computed from them."""
FINAL_STAGES = ("resection", "absolute")
"""Stages whose result is the orientation itself."""


def missing_lists(name: str, available: Collection[str]) -> list[str]:
    """Lists that nobody has added, without which `name` cannot be computed; empty where a run is enough."""
    if name in available:
        return []
    if name not in BY_NAME:
        return [name]
    stage = BY_NAME[name]
    ways = [missing_lists(other, available) for other in stage.needs_one_of]
    shortest = min(ways, key=len, default=[])
    found = [one for other in stage.required for one in missing_lists(other, available)] + shortest
    return list(dict.fromkeys(found))


def how_to_get(names: Iterable[str], available: Collection[str], project: str = "PROJECT") -> str:
    """What brings the stages `names`: the list to add first, or a run."""
    lists = [one for name in names for one in missing_lists(name, available)]
    if lists:
        return f"Add the list {lists[0]}: orient add {project} {lists[0]} FILE -m why"
    return f"Run: orient run {project}"


def is_optional(name: str, waits_for: str) -> bool:
    """Others can do without this stage, or nobody has asked for it: nothing is wrong when its inputs are missing."""
    wanted_with = BY_NAME[name].wanted_with
    return any(name in stage.optional for stage in STAGES) or (
        wanted_with != "" and wanted_with in waits_for.split(", ")
    )
