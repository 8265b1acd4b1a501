"""What a notebook hands in, as arrays of the right shape, or one clear sentence why not."""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.door.arrays import are_covariances
from orient.errors import UsageError
from orient.pipeline.photo_model import PhotoModel

Array = NDArray[np.float64]
System = Literal["px", "comparator", "image"]
SYSTEMS = ("px", "comparator", "image")


def rows_of(values: ArrayLike, width: int, what: str) -> Array:
    """(n, width) finite numbers; one row may come alone."""
    rows = np.atleast_2d(_numbers(values, what))
    if rows.ndim != 2 or rows.shape[1] != width:
        raise UsageError(f"{what} has the shape {_shape(values)}, not (n, {width})")
    return rows


def for_each(values: ArrayLike, n: int, what: str) -> Array:
    """(n,) finite numbers; one number stands for all."""
    numbers = _numbers(values, what)
    if numbers.shape not in ((), (n,)):
        raise UsageError(f"{what} has the shape {_shape(values)}; it is one number, or one for each of {n} points")
    return np.broadcast_to(numbers, (n,))


def sigmas_of(values: ArrayLike, n: int, what: str) -> Array:
    """(n,) standard deviations, not negative."""
    sigmas = for_each(values, n, what)
    if np.any(sigmas < 0):
        raise UsageError(f"{what} is negative")
    return sigmas


def covariances_of(values: ArrayLike | None, n: int, what: str) -> Array:
    """(n, 3, 3) symmetric; one (3, 3) stands for all, None for no error."""
    if values is None:
        return np.zeros((n, 3, 3))
    matrices = _numbers(values, what)
    if matrices.shape not in ((3, 3), (n, 3, 3)):
        raise UsageError(f"{what} has the shape {_shape(values)}, not (3, 3) or ({n}, 3, 3)")
    if not are_covariances(matrices):
        raise UsageError(f"{what} is not symmetric, or a variance is negative")
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


def _numbers(values: ArrayLike, what: str) -> Array:
    try:
        numbers = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise UsageError(f"{what} holds something that is no number, or rows of different length") from None
    if not np.all(np.isfinite(numbers)):
        raise UsageError(f"{what} holds NaN or infinity")
    return numbers


def _shape(values: ArrayLike) -> tuple[int, ...]:
    return np.shape(values)
