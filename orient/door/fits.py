"""Similarity, polynomial and ground covariances of arrays, without a project."""

from dataclasses import fields
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.door.arrays import LARGEST, array_of, numbers, points_of, require_covariances
from orient.errors import UsageError, require_numba
from orient.solvers.ground_covariance import covariance_by_orientation
from orient.solvers.lean_polynomial import LeanPolynomial, lean_polynomial
from orient.solvers.lean_similarity import LeanSimilarity, lean_similarity

Array = NDArray[np.float64]
LEAST_POINTS = 3
HIGHEST_DEGREE = 20
LEAST_WEIGHT = 1e-30
"""Of points with weights below it and above its inverse, squares of the sums would vanish or overflow."""
UP = (0.0, 0.0, 1.0)


class Polynomial(LeanPolynomial):
    """What the solver found; the places it is asked for are looked at before."""

    __slots__ = ()

    @classmethod
    def of(cls, found: LeanPolynomial) -> Self:
        """The same numbers."""
        return cls(*(getattr(found, field.name) for field in fields(found)))

    def values(self, XY: ArrayLike, *, compiled: bool = False) -> Array:
        """z (k, c) at places XY (k, 2); `compiled` by numba (extra `orient[fast]`), the same to 1e-9."""
        return LeanPolynomial.values(self, self._places(XY), compiled=compiled)

    def leverages(self, XY: ArrayLike) -> Array:
        """h = rows Q rows' (k,): variance of z at XY by sigma0^2; 1 - h is the redundancy number of a fitted point."""
        return LeanPolynomial.leverages(self, self._places(XY))

    def _places(self, XY: ArrayLike) -> Array:
        """(k, 2) whose highest powers and their squares are numbers."""
        places = points_of("XY", XY, 2, or_one=True)
        farthest = np.abs(places - self.centre).max(initial=0.0)
        if not farthest < self.scale * LARGEST ** (1.0 / self.degree):
            raise UsageError("XY lies so far from the points of the fit that powers overflow", "Give nearer places.")
        return places


def similarity(
    model: ArrayLike, ground: ArrayLike, weights: ArrayLike | None = None, *, compiled: bool = False
) -> LeanSimilarity:
    """R, H, X0 of X_G = R x/H + X0 and the 7 x 7 cofactors: least squares in closed form, nothing is stored.

    `model` (n, 3) in its own unit, without errors; `ground` (n, 3) [m]; both right-handed, three points off a line or
    more; `weights` (n,) = sigma0^2/sigma^2 of the ground points, equal by default. H in model units per metre, Q of
    (r, H, X0) with R_new = exp([r]x) R; covariance = sigma0^2 Q. `is_mirrored` where the mirrored model fits far
    better: then the two are of opposite handedness, and this is no result. `compiled`: by numba (`orient[fast]`), the
    same to 1e-9; loading it takes half a second, so it is for many calls.
    """
    x, P = points_of("model", model, 3), points_of("ground", ground, 3)
    _require_as_many("model", x, "ground", P)
    if len(x) < LEAST_POINTS:
        raise UsageError(f"{len(x)} points do not determine a similarity", f"Give at least {LEAST_POINTS}.")
    p = None if weights is None else array_of("weights", weights, (len(x),))
    if p is not None and not np.all((p > LEAST_WEIGHT) & (p < 1.0 / LEAST_WEIGHT)):
        told = f"weights are not all between {LEAST_WEIGHT:g} and {1.0 / LEAST_WEIGHT:g}"
        raise UsageError(told, "Give sigma0^2/sigma^2, and leave out points that should not count.")
    require_numba(compiled)
    return lean_similarity(x, P, p, compiled=compiled)


def polynomial(XY: ArrayLike, z: ArrayLike, degree: int) -> Polynomial:
    """z = sum c_jk u^j v^k, j + k <= degree, of the columns of z (n, c) at XY (n, 2): least squares, nothing is stored.

    u, v are XY from the middle of their extent, in units of half its longer side: `orient digitize` finds the same
    coefficients. `values(XY)` evaluates, with `compiled=True` by numba; `leverages(XY)` sigma0^2 is the variance there;
    covariance = sigma0^2 Q.
    """
    places, values = points_of("XY", XY, 2), points_of("z", z)
    _require_as_many("XY", places, "z", values)
    if array_of("degree", degree, ()).item() not in range(1, HIGHEST_DEGREE + 1):
        raise UsageError(f"degree {degree} is not in 1 ... {HIGHEST_DEGREE}")
    return Polynomial.of(lean_polynomial(places, values, int(degree)))


def ground_covariances(
    ground: ArrayLike,
    station: ArrayLike,
    covariance: ArrayLike,
    up: ArrayLike = UP,
    *,
    plan: bool = False,
    compiled: bool = False,
) -> Array:
    """K (n, 3, 3) [m^2]: how sure are the places where rays meet their level planes, from the orientation alone.

    `ground` (n, 3) [m] the places, `station` (3,), `covariance` (6, 6) of (r, S) [rad, m] as `orient.resection` gives
    it times sigma0^2, `up` the vertical, (3,) or (n, 3). NaN where a ray is level. Readings and heights add their own
    parts: `photo.image_to_ground` has all three. `plan`: K (n, 2, 2) of the first two coordinates alone. `compiled`: by
    numba, as in `similarity`.
    """
    P = points_of("ground", ground, 3)
    S, K = array_of("station", station, (3,)), array_of("covariance", covariance, (6, 6))
    n = array_of("up", up, (3,) if numbers("up", up).ndim == 1 else P.shape)
    require_covariances("covariance", K)
    if not np.all(np.linalg.norm(n, axis=-1) > 0):
        raise UsageError("up has no direction", "Give the vertical, for example (0, 0, 1).")
    require_numba(compiled)
    return covariance_by_orientation(P, S, K, n, plan=plan, compiled=compiled)


def _require_as_many(first: str, a: Array, second: str, b: Array) -> None:
    if len(a) != len(b):
        raise UsageError(
            f"{first} has {len(a)} points and {second} {len(b)}", "Give as many of the one as of the other."
        )
