"""The stages: what each one reads, in which order they run, and their settings. Imports no mathematics."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Protocol, cast

from orient.values import Outcome, Settings, Tables

INPUT_STAGES = ("photo", "readings", "sheet", "control", "model")


class Compute(Protocol):
    def __call__(self, inputs: Mapping[str, Tables], settings: Settings) -> Outcome: ...


@dataclass(frozen=True, slots=True)
class Stage:
    """One computed stage. `version` rises when the computation changes in a way that can change a number.

    Settings of the current version hold for the next one too, but for `not_kept`: a consent is given once.
    """

    name: str
    version: int
    title: str
    required: tuple[str, ...]
    optional: tuple[str, ...] = ()
    needs_one_of: tuple[str, ...] = ()
    settings: Mapping[str, str | int | float | bool | None] = field(default_factory=dict)
    not_kept: tuple[str, ...] = ()

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
        1,
        "image coordinates: cycle means, interior orientation, distortion, refraction, curvature",
        required=("photo", "readings"),
        settings={"reject": False},
    ),
    Stage(
        "digitize",
        1,
        "map points: polynomial of each sheet",
        required=("photo", "sheet"),
        settings={"degree": None, "choice": "f-test", "reject": False},
    ),
    Stage(
        "bl",
        1,
        "B, L, H of the points on the ground's ellipsoid",
        required=("photo",),
        optional=("control", "digitize"),
        needs_one_of=("control", "digitize"),
        settings={"allow_ballpark": False},
        not_kept=("allow_ballpark",),
    ),
    Stage(
        "topocentric",
        1,
        "topocentric coordinates T and T'",
        required=("photo", "bl"),
        settings={"radius": "exact"},
    ),
    Stage(
        "resection",
        2,
        "exterior orientation",
        required=("photo", "refine", "topocentric"),
        optional=("digitize",),
        settings={
            "engine": "zlatanov",
            "control": "auto",
            "correlation": "sheet",
            "variance": "posteriori",
            "estimate": "none",
            "calibrate": "none",
            "camera": "fixed",
            "free_camera": False,
            "distortion": "camera",
            "max_iterations": 50,
            "tolerance": 1e-10,
        },
    ),
    Stage(
        "covariance",
        1,
        "covariance of ground points, K = C Q C'",
        required=("photo", "refine", "topocentric", "resection"),
        settings={"pairs": False},
    ),
)
BY_NAME = {stage.name: stage for stage in STAGES}
ALL_STAGES = INPUT_STAGES + tuple(BY_NAME)


FINAL_STAGES = ("resection",)
"""Stages whose result is the orientation itself."""


def is_optional(name: str) -> bool:
    """A stage that others can do without: when its inputs are missing, nothing is wrong."""
    return any(name in stage.optional for stage in STAGES)
