"""Current results in the formats of other programs. This page imports no mathematics."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Protocol, cast

from orient.errors import UsageError


@dataclass(frozen=True, slots=True)
class Options:
    """What a user can ask of an export; each format takes those that concern it.

    `crs`: of a GeoPackage, "" for the map's. `magnify`: of residual vectors and ellipses on the map, None for a round
    number that shows them. `pixel_mm`: size of a pixel where the photo has none.
    """

    crs: str = ""
    allow_ballpark: bool = False
    magnify: float | None = None
    pixel_mm: float | None = None


@dataclass(frozen=True, slots=True)
class Format:
    """One format: its name, what it holds, the endings of its files, and the stages it needs.

    `is_streamed`: points go from the project to the file a page at a time.
    """

    name: str
    holds: str
    endings: tuple[str, ...]
    stages: tuple[str, ...]
    module: str
    is_text: bool = True
    is_streamed: bool = False


@dataclass(frozen=True, slots=True)
class Made:
    """An export in pieces of bytes; `beside`: a second file that belongs to it, by what is added to its name."""

    content: Iterable[bytes]
    beside: Mapping[str, bytes]


class Make(Protocol):
    def __call__(self, path: Path, form: Format, ending: str, name: str, options: Options) -> Made: ...


ORIENTED = ("photo", "refine", "topocentric", "resection")
ON_THE_GROUND = (*ORIENTED, "bl", "covariance")
FORMATS = (
    Format("geojson", "layers for a map in WGS 84", (".geojson", ".json"), ON_THE_GROUND, "geojson"),
    Format("gpkg", "GeoPackage: the same layers with styles for QGIS", (".gpkg",), ON_THE_GROUND, "geopackage", False),
    Format("opencv", "rvec, tvec, K, dist and the control", (".yml", ".yaml", ".json"), ORIENTED, "opencv_file"),
    Format("opk", "omega, phi, kappa and projection centre", (".csv",), ORIENTED, "tables", is_streamed=True),
    Format("elements", "every element of the orientation", (".csv",), ORIENTED, "tables", is_streamed=True),
    Format("residuals", "image residuals", (".csv",), ORIENTED, "tables", is_streamed=True),
    Format(
        "points", "points on the ground with their covariance", (".csv",), ON_THE_GROUND, "tables", is_streamed=True
    ),
)
BY_NAME = {form.name: form for form in FORMATS}


def format_named(name: str) -> Format:
    """The format; a `UsageError` lists what there is."""
    if name not in BY_NAME:
        raise UsageError(f'there is no format "{name}"', f"Formats are {', '.join(BY_NAME)}.")
    return BY_NAME[name]


def make(path: Path, form: Format, ending: str, name: str, options: Options) -> Made:
    """The export of the current results; the same project gives the same bytes. `name`: of the file, for references."""
    module = import_module(f"orient.export.{form.module}")
    return cast(Make, module.make)(path, form, ending, name, options)
