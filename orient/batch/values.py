"""What travels between the coordinator, the workers and the summary: plain frozen values that pickle."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from orient.intake.options import ReadOptions
from orient.values import Scalar, Settings

LOST_CODE = 70
GOOD = 0


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why a photo has no result: the sentence, the remedy, and the exit code that `orient run` gives for it alone."""

    message: str
    hint: str
    exit_code: int


@dataclass(frozen=True, slots=True)
class Item:
    """One photo to be worked through. `source`: folder to make the project from, if there is no project yet.

    `refusal`: what was wrong with its name before anything was opened.
    """

    path: str
    source: str = ""
    refusal: Refusal | None = None


@dataclass(frozen=True, slots=True)
class Order:
    """What to do with every photo. `reading`: how the lists of a `source` are written."""

    settings: Settings = field(default_factory=dict)
    reason: str = "batch"
    reading: ReadOptions = field(default_factory=ReadOptions)


@dataclass(frozen=True, slots=True)
class Ending:
    """How one photo ended. `numbers`: columns of `orient_photo`; the others are rows of the tables of that name."""

    path: str
    exit_code: int
    message: str = ""
    hint: str = ""
    numbers: Mapping[str, Scalar] = field(default_factory=dict)
    covariances: Sequence[Mapping[str, Scalar]] = ()
    stages: Sequence[Mapping[str, Scalar]] = ()
    findings: Sequence[Mapping[str, Scalar]] = ()

    @property
    def is_failed(self) -> bool:
        return self.exit_code != GOOD
