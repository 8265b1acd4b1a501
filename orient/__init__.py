"""orient: the orientation of one frame photograph, with its whole proof in one SQLite file.

From Python: `photo = orient.open("hadley.sqlite")`, or `orient.new(path, folder)`; docs/python.md tells the rest.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from orient.door.fits import ground_covariances as ground_covariances
    from orient.door.fits import polynomial as polynomial
    from orient.door.fits import similarity as similarity
    from orient.door.orientation import Orientation as Orientation
    from orient.door.photo import Photo as Photo
    from orient.door.photo import new as new
    from orient.door.photo import open as open
    from orient.door.picture import Picture as Picture
    from orient.door.places import GroundPlaces as GroundPlaces
    from orient.door.places import ImagePlaces as ImagePlaces
    from orient.door.resections import resection as resection
    from orient.door.resections import resections as resections
    from orient.door.status import Done as Done
    from orient.door.status import Finding as Finding
    from orient.door.status import Status as Status
    from orient.door.table import Table as Table
    from orient.errors import GeometryError as GeometryError
    from orient.errors import InputError as InputError
    from orient.errors import OrientError as OrientError
    from orient.errors import ProjectError as ProjectError
    from orient.errors import UsageError as UsageError

_HOMES = {
    "open": "orient.door.photo",
    "new": "orient.door.photo",
    "Photo": "orient.door.photo",
    "Orientation": "orient.door.orientation",
    "GroundPlaces": "orient.door.places",
    "ImagePlaces": "orient.door.places",
    "Table": "orient.door.table",
    "Picture": "orient.door.picture",
    "Status": "orient.door.status",
    "Finding": "orient.door.status",
    "Done": "orient.door.status",
    "resection": "orient.door.resections",
    "resections": "orient.door.resections",
    "similarity": "orient.door.fits",
    "polynomial": "orient.door.fits",
    "ground_covariances": "orient.door.fits",
    "OrientError": "orient.errors",
    "InputError": "orient.errors",
    "GeometryError": "orient.errors",
    "UsageError": "orient.errors",
    "ProjectError": "orient.errors",
}
"""Where each public name lives: nothing is imported before it is asked for."""

__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'orient' has no attribute {name!r}")
    found = globals()[name] = getattr(import_module(_HOMES[name]), name)  # asked for once
    return found


def __dir__() -> list[str]:
    return sorted(__all__)
