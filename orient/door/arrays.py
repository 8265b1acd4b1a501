"""What a notebook hands in, as arrays of numbers, or one clear sentence why not."""

from decimal import Decimal
from numbers import Real
from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.errors import UsageError

Array = NDArray[np.float64]
LARGEST = 1e60
"""Fourth powers of it are still numbers."""
ROUNDING = 1e-9
"""Of a covariance to the product of its standard deviations."""
ON_POINTS = "Leave out points without coordinates."


def array_of(name: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Numbers of that shape."""
    array = numbers(name, values)
    if array.shape != shape:
        raise UsageError(
            f"{name} has the shape {array.shape}", f"Give {name} {shape}." if shape else "Give one number."
        )
    return array


def points_of(name: str, values: ArrayLike, width: int | None = None, *, or_one: bool = False) -> Array:
    """(n, width) numbers, of any width without one; with `or_one` one point may come alone, (width,)."""
    array = numbers(name, values, ON_POINTS)
    if or_one and array.ndim == 1:
        array = array[None]
    if array.ndim != 2 or array.shape[1] != (width or max(array.shape[1], 1)):
        raise UsageError(f"{name} has the shape {array.shape}", f"Give {name} (n, {width or 'c'}).")
    return array


def numbers(name: str, values: ArrayLike, hint: str = "") -> Array:
    """An array of any shape; each number is real, finite and below `LARGEST`. The hint: what to do about those not."""
    array = values if _are_floats(values) else _converted(name, values)
    if not np.vdot(array, array) < LARGEST**2:  # one quick pass; neither NaN nor infinity is below
        raise UsageError(f"{name} has numbers that are not finite or beyond {LARGEST:g}", hint)
    return array


def require_covariances(name: str, matrices: Array) -> None:
    """(k, k) or (n, k, k): symmetric and without negative eigenvalues but for rounding; they may be singular."""
    bad = np.flatnonzero(~_are_covariances(matrices))
    if len(bad):
        which = name if matrices.ndim == 2 else f"{name}[{bad[0]}]"
        raise UsageError(f"{which} is no covariance matrix", "It is symmetric and has no negative eigenvalue.")


def _are_floats(values: object) -> TypeGuard[Array]:
    return type(values) is np.ndarray and values.dtype == np.float64


def _converted(name: str, values: ArrayLike) -> Array:
    if _has_masked(values):
        raise UsageError(f"{name} has masked elements", "Leave out what is masked.")
    try:
        given = np.asarray(values)
    except (TypeError, ValueError):
        raise UsageError(f"{name} is no array of numbers", "Give numbers in rows of one length.") from None
    if not _is_real(given):
        raise UsageError(f"{name} holds something that is no real number", "Give whole numbers or floats.")
    return _as_floats(given)


def _has_masked(values: object) -> bool:
    if isinstance(values, list | tuple):
        return any(map(_has_masked, values))
    return isinstance(values, np.ma.MaskedArray) and bool(np.ma.is_masked(values))


def _is_real(given: NDArray[np.generic]) -> bool:
    """Whole numbers beyond 64 bits, fractions and decimals come as objects."""
    if given.dtype == object:
        return all(isinstance(one, Real | Decimal) for one in given.flat)
    return given.dtype.kind in "biuf"


def _as_floats(given: NDArray[np.generic]) -> Array:
    """What is too large for a float is infinite."""
    try:
        with np.errstate(over="ignore"):
            return given.astype(np.float64, copy=False)
    except (OverflowError, ValueError):  # 10**400, a decimal that signals
        return np.full(given.shape, np.inf)


def _are_covariances(matrices: Array) -> NDArray[np.bool_]:
    """(...) of (..., k, k), by their correlations; without a variance there are none."""
    sigmas = np.sqrt(np.maximum(np.diagonal(matrices, axis1=-2, axis2=-1), 0.0))
    scales, has_error = np.where(sigmas > 0.0, sigmas, 1.0), sigmas > 0.0
    with np.errstate(over="ignore"):
        R = matrices / scales[..., :, None] / scales[..., None, :]
    largest = (1.0 + ROUNDING) * (has_error[..., :, None] & has_error[..., None, :])
    fits = np.all((np.abs(R) <= largest) & (np.abs(R - R.mT) <= ROUNDING), axis=(-2, -1))
    lowest = np.linalg.eigvalsh(np.where(fits[..., None, None], R, 0.0))[..., 0]
    return np.asarray(fits & (lowest >= -ROUNDING))
