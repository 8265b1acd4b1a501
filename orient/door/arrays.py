"""Arrays that are handed to the functions without a project, or one clear sentence why not."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.errors import UsageError

Array = NDArray[np.float64]


def array_of(name: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Finite numbers of that shape."""
    array = np.asarray(values, dtype=np.float64)
    if array.shape != shape:
        raise UsageError(f"{name} has the shape {array.shape}", f"Give {name} {shape}.")
    require_finite(name, array)
    return array


def points_of(name: str, values: ArrayLike, width: int | None = None) -> Array:
    """(n, width) finite numbers, of any width without one."""
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != (width or max(array.shape[1], 1)):
        raise UsageError(f"{name} has the shape {array.shape}", f"Give {name} (n, {width or 'c'}).")
    require_finite(name, array)
    return array


def require_finite(name: str, array: Array) -> None:
    if not np.isfinite(array).all():
        raise UsageError(f"{name} has numbers that are not finite", "Leave out points without coordinates.")
