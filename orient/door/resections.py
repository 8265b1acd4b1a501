"""Resections of arrays, without a project: one photo, or many at once."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.door.arrays import ON_POINTS, array_of, numbers, require_covariances
from orient.errors import UsageError, require_numba
from orient.solvers.batch_iteration import BatchResection
from orient.solvers.resection_batch import resection_batch

if TYPE_CHECKING:
    from orient.solvers.lean_resection import LeanResection

Array = NDArray[np.float64]
LEAST_POINTS, NO_TURN = 3, np.eye(3)
ROUGHEST, EXACT = 0.1, 1e-14
"""Largest element of R R' - I of a matrix that may be meant as a rotation, and of one that is left as it is."""


def resection(
    image: ArrayLike,
    ground: ArrayLike,
    f_mm: float,
    rotation: ArrayLike,
    station: ArrayLike,
    ground_cofactor: ArrayLike | None = None,
) -> "LeanResection":
    """R, S and the 6 x 6 cofactors of one photo from rough R, S: least squares and nothing else, nothing is stored.

    `image` (n, 2) [mm], refined; `ground` (n, 3) [m], right-handed, without errors, or with covariance / sigma0^2
    `ground_cofactor` (n, 3, 3) [m^2/mm^2]; `rotation` (3, 3) image axes to ground, `station` (3,). Q belongs to
    (r, S) with R_new = exp([r]x) R; covariance = sigma0^2 Q, sigma0 [mm]. `converged` is False where it leads nowhere.
    """
    from orient.solvers.lean_resection import lean_resection

    x, P = _matched(image, ground, "n")
    start = _rotations(rotation, (3, 3)), array_of("station", station, (3,))
    S = None if ground_cofactor is None else array_of("ground_cofactor", ground_cofactor, (len(x), 3, 3))
    if S is not None:
        require_covariances("ground_cofactor", S)
    return lean_resection(x, P, _focal_lengths(f_mm, 1).item(), *start, S)


def resections(
    image: ArrayLike,
    ground: ArrayLike,
    f_mm: ArrayLike,
    rotation: ArrayLike | None = None,
    station: ArrayLike | None = None,
    *,
    compiled: bool | None = None,
) -> BatchResection:
    """The same for p photos of n points each: `image` (p, n, 2), `ground` (p, n, 3), `f_mm` one or (p,).

    `rotation` (p, 3, 3), `station` (p, 3): rough values; without both, each photo begins as a vertical one and, where
    that leads to no good fit, with the starts of `orient resection`. `compiled`: with numba (`orient[fast]`), by
    default where it is installed and there are 100 000 points or more; of photos that fit, the results
    agree to 1e-9.
    """
    x, P = _matched(image, ground, "p, n")
    if (rotation is None) != (station is None):
        raise UsageError("rotation and station are only of use together", "Give both, or neither.")
    p = len(x)
    R = None if rotation is None else _rotations(rotation, (p, 3, 3))
    S = None if station is None else array_of("station", station, (p, 3))
    require_numba(compiled)
    return resection_batch(x, P, _focal_lengths(f_mm, p), R, S, compiled=compiled)


def _matched(image: ArrayLike, ground: ArrayLike, points: str) -> tuple[Array, Array]:
    x, P = numbers("image", image, ON_POINTS), numbers("ground", ground, ON_POINTS)
    dimensions = points.count(",") + 2
    fits = x.ndim == P.ndim == dimensions and x.shape[:-1] == P.shape[:-1] and (x.shape[-1], P.shape[-1]) == (2, 3)
    if not fits:
        told = f"image has the shape {x.shape} and ground {P.shape}"
        raise UsageError(told, f"Give image ({points}, 2) and ground ({points}, 3).")
    if x.shape[-2] < LEAST_POINTS:
        raise UsageError(f"{x.shape[-2]} points do not determine a photo", f"Give at least {LEAST_POINTS}.")
    return x, P


def _rotations(values: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Rough rotations: the nearest ones, because the iteration only turns what it is given."""
    R = array_of("rotation", values, shape)
    apart = np.abs(R @ R.mT - NO_TURN).max(initial=0.0)
    if apart > ROUGHEST or (np.linalg.det(R) < 0).any():
        raise UsageError("rotation is no rotation matrix", "Give image axes to right-handed ground axes, det = +1.")
    if apart < EXACT:
        return R
    U, _, Vt = np.linalg.svd(R)
    return np.asarray(U @ Vt)


def _focal_lengths(f_mm: ArrayLike, p: int) -> Array:
    f = numbers("f_mm", f_mm)
    wanted = "Give one focal length [mm]" + (f", or one for each of {p} photos." if p != 1 else ".")
    if f.shape not in ((), (p,)):
        raise UsageError(f"f_mm has the shape {f.shape}", wanted)
    if not (f > 0).all():
        raise UsageError("f_mm is not positive", wanted)
    return f
