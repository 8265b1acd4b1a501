"""Arrays that are handed to the functions without a project, or one clear sentence why not."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.errors import UsageError

Array = NDArray[np.float64]
LARGEST = 1e60
"""Fourth powers of it are still numbers."""
ROUNDING = 1e-9
"""Of a covariance to the product of its standard deviations."""


def array_of(name: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Finite numbers of that shape."""
    array = numbers(name, values)
    if array.shape != shape:
        raise UsageError(f"{name} has the shape {array.shape}", f"Give {name} {shape}.")
    require_finite(name, array)
    return array


def points_of(name: str, values: ArrayLike, width: int | None = None) -> Array:
    """(n, width) finite numbers, of any width without one."""
    array = numbers(name, values)
    if array.ndim != 2 or array.shape[1] != (width or max(array.shape[1], 1)):
        raise UsageError(f"{name} has the shape {array.shape}", f"Give {name} (n, {width or 'c'}).")
    require_finite(name, array)
    return array


def numbers(name: str, values: ArrayLike) -> Array:
    """An array of numbers, of any shape."""
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise UsageError(f"{name} is no array of numbers: {error}", "Give rows of one length.") from None


def require_finite(name: str, array: Array) -> None:
    if not (array.min(initial=0.0) > -LARGEST and array.max(initial=0.0) < LARGEST):
        told = f"{name} has numbers that are not finite or beyond {LARGEST:g}"
        raise UsageError(told, "Leave out points without coordinates.")


def are_covariances(K: Array) -> bool:
    """(..., k, k) symmetric but for rounding, no negative variance; a factor of them is looked for later."""
    variances = np.diagonal(K, axis1=-2, axis2=-1)
    sigmas = np.sqrt(np.maximum(variances, 0.0))
    products = sigmas[..., :, None] * sigmas[..., None, :]
    return bool(np.all(variances >= 0.0) and np.all(np.abs(K - K.mT) <= ROUNDING * products))
