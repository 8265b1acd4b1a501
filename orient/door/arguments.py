"""What a notebook hands in to a `Photo`, in the shape of its points, or one clear sentence why not."""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.door.arrays import numbers, require_covariances
from orient.errors import UsageError
from orient.pipeline.photo_model import PhotoModel

Array = NDArray[np.float64]
System = Literal["px", "comparator", "image"]
SYSTEMS = ("px", "comparator", "image")


def for_each(values: ArrayLike, n: int, what: str) -> Array:
    """(n,) numbers; one number stands for all."""
    given = numbers(what, values)
    if given.shape not in ((), (n,)):
        raise UsageError(f"{what} has the shape {given.shape}; it is one number, or one for each of {n} points")
    return np.broadcast_to(given, (n,))


def sigmas_of(values: ArrayLike, n: int, what: str) -> Array:
    """(n,) standard deviations, not negative."""
    sigmas = for_each(values, n, what)
    if np.any(sigmas < 0):
        raise UsageError(f"{what} is negative")
    return sigmas


def covariances_of(values: ArrayLike | None, n: int, what: str) -> Array:
    """(n, 3, 3) covariances; one (3, 3) stands for all, None for no error."""
    if values is None:
        return np.zeros((n, 3, 3))
    matrices = numbers(what, values)
    if matrices.shape not in ((3, 3), (n, 3, 3)):
        raise UsageError(f"{what} has the shape {matrices.shape}, not (3, 3) or ({n}, 3, 3)")
    require_covariances(what, matrices)
    return np.broadcast_to(matrices, (n, 3, 3))


def system_of(system: str | None, model: PhotoModel) -> System:
    """The named system, or that of the project's own readings."""
    if system is None:
        return "px" if model.in_pixels else "comparator"
    if system not in SYSTEMS:
        raise UsageError(f'there is no system "{system}"', f"Systems are {', '.join(SYSTEMS)}.")
    if system == "px" and model.photo["pixel_size_mm"] is None:
        raise UsageError("the photo has no pixels", "Give [pixels] in photo.toml, or coordinates in mm.")
    return system  # type: ignore[return-value]
