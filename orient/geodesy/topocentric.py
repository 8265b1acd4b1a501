"""The topocentric system T = (X north, Y east, Z up) of an origin (B_N, L_N, H_N); T' = T turned by gamma about up.

T and T' are LEFT-handed, as in the seed. B, L are geodetic latitude and longitude in radians (L positive east), H the
ELLIPSOIDAL height; lengths in metres. The origin of the papers is the nadir point on the physical surface, but any
point will do. Geocentric X, Y, Z are right-handed: X to B = L = 0, Z along the axis.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.geodesy.ellipsoid import Ellipsoid, prime_vertical_radius

Array = NDArray[np.float64]

Radius = Callable[[Ellipsoid, ArrayLike], Array]
Constants = tuple[float, float, float, float, float, float, float]
"""sin B_N, cos B_N, N_N, V_N, H_N, e^2, e'^2 of origin and ellipsoid."""

LATITUDE_STEPS = 20
NEWTON = 3.0
"""Bound of the constant of Newton's convergence; 0.75 on the Earth, 2.7 on an ellipsoid of 1/f = 2."""
STANDS_STILL = 3e-17
SMALLEST = 1e-300
POINTS_AT_ONCE = 8192
"""Points whose intermediate numbers stay in the processor's cache."""


@dataclass(frozen=True, slots=True)
class Origin:
    """Origin of T: geodetic latitude B, longitude L [rad], ellipsoidal height H [m]."""

    B: float
    L: float
    H: float


def topocentric_from_geographic(
    B: ArrayLike,
    L: ArrayLike,
    H: ArrayLike,
    origin: Origin,
    ellipsoid: Ellipsoid,
    radius: Radius = prime_vertical_radius,
    *,
    compiled: bool = False,
) -> Array:
    """T (n, 3) = (X north, Y east, Z up) [m] of points B, L [rad], H [m] (n,), by the closed formulas of seed 004 (2).

        X = (N+H) sin dB + nu cosB sinB_N - Q cosB_N
        Y = (N+H) cosB sin l
        Z = [N_N e'^2 sin dB sin(B+B_N)/(V (V_N+V)) + H - H_N] cos dB - 2 (N_N+H_N) sin^2(dB/2)
            - nu cosB cosB_N - Q sinB_N

    dB = B - B_N, l = L - L_N, V = sqrt(1 + e'^2 cos^2 B), Q = e^2 (N sinB - N_N sinB_N), nu = 2 (N+H) sin^2(l/2).
    Corrected as in EQUATIONS 4 (H - H_N; N from the point's own latitude; Y' and X' of the paper are X and Y here).
    Exact at any distance, on any ellipsoid, at the poles and across the date line (l enters only as sine). `radius`
    gives N: exact, or the paper's `prime_vertical_polynomial`. `compiled`: the exact one by numba (extra
    `orient[fast]`), the same numbers; no stage asks for it.
    """
    B, L, H = np.broadcast_arrays(*(np.asarray(value, dtype=np.float64) for value in (B, L, H)))
    shape, is_exact = B.shape, radius is prime_vertical_radius
    B, L, H = B.ravel(), L.ravel(), H.ravel()
    constants = _constants(origin, ellipsoid, radius)
    T = np.empty((B.size, 3))
    for begin in range(0, B.size, POINTS_AT_ONCE):
        part = slice(begin, begin + POINTS_AT_ONCE)
        t_B, t_L = np.tan(0.5 * (B[part] - origin.B)), np.tan(0.5 * (L[part] - origin.L))
        if is_exact and compiled:
            _compiled(t_B, t_L, H[part], constants, T[part])
        else:
            N = None if is_exact else radius(ellipsoid, B[part])
            T[part, 0], T[part, 1], T[part, 2] = by_half_tangents(t_B, t_L, H[part], constants, N)
    return T.reshape(*shape, 3)


def by_half_tangents(
    t_B: Array, t_L: Array, H: Array, constants: Constants, N: Array | None
) -> tuple[Array, Array, Array]:
    """X, Y, Z from t_B = tan(dB/2), t_L = tan(l/2), the points' own N being exact where it is None.

    All sines and cosines follow by products without loss: sin = 2 t/(1 + t^2), 1 - cos = t sin.
    """
    sin_N, cos_N, N_N, V_N, H_N, e2, ep2 = constants
    sin_dB, sin_l = t_B * (2.0 / (1.0 + t_B * t_B)), t_L * (2.0 / (1.0 + t_L * t_L))
    versine, versine_l = t_B * sin_dB, t_L * sin_l
    cos_dB = 1.0 - versine
    sin_B, cos_B = sin_N * cos_dB + cos_N * sin_dB, cos_N * cos_dB - sin_N * sin_dB
    V = np.sqrt(1.0 + (ep2 * cos_B) * cos_B)
    # = N - N_N without cancellation
    dN = (N_N * ep2) * sin_dB * (cos_N * sin_B + sin_N * cos_B) / (V * (V_N + V))
    arm = (N_N + dN if N is None else N) + H
    p = arm * cos_B
    nu = p * versine_l
    Q = e2 * (dN * sin_B + (N_N * cos_N) * sin_dB - (N_N * sin_N) * versine)
    X = arm * sin_dB + sin_N * nu - cos_N * Q
    Z = (dN + (H - H_N)) * cos_dB - (N_N + H_N) * versine - cos_N * nu - sin_N * Q
    return X, p * sin_l, Z


def _constants(origin: Origin, ellipsoid: Ellipsoid, radius: Radius) -> Constants:
    sin_N, cos_N, e2, ep2 = math.sin(origin.B), math.cos(origin.B), ellipsoid.e2, ellipsoid.ep2
    return sin_N, cos_N, float(radius(ellipsoid, origin.B)), math.sqrt(1.0 + ep2 * cos_N * cos_N), origin.H, e2, ep2


def _compiled(t_B: Array, t_L: Array, H: Array, constants: Constants, T: Array) -> None:
    from orient.geodesy.topocentric_kernel import topocentric

    topocentric(t_B, t_L, H, constants, T)


def geographic_from_topocentric(T: ArrayLike, origin: Origin, ellipsoid: Ellipsoid) -> Array:
    """(B, L, H) (n, 3) [rad, rad, m] of T (n, 3) [m]: T -> geocentric -> geographic; inverse of the closed formulas."""
    axes = local_axes(origin.B, origin.L)
    at_origin = geocentric_from_geographic(origin.B, origin.L, origin.H, ellipsoid)
    return _geographic(T, lambda rows: at_origin[:, None] + axes @ rows.T, ellipsoid)


def geocentric_from_geographic(B: ArrayLike, L: ArrayLike, H: ArrayLike, ellipsoid: Ellipsoid) -> Array:
    """X = (N+H) cosB cosL, Y = (N+H) cosB sinL, Z = (N (1-e^2) + H) sinB: (n, 3) [m] of B, L [rad], H [m] (n,)."""
    B, L, H = (np.asarray(value, dtype=np.float64) for value in (B, L, H))
    N = prime_vertical_radius(ellipsoid, B)
    p = (N + H) * np.cos(B)
    return np.stack([p * np.cos(L), p * np.sin(L), (N * (1.0 - ellipsoid.e2) + H) * np.sin(B)], axis=-1)


def geographic_from_geocentric(XYZ: ArrayLike, ellipsoid: Ellipsoid) -> Array:
    """(B, L, H) (n, 3) [rad, rad, m] of geocentric XYZ (n, 3) [m].

        tan B = (Z + e'^2 b sin^3 beta)/(p - e^2 a cos^3 beta), tan beta = (b/a) tan B, p = sqrt(X^2 + Y^2)

    a step of Newton, repeated until B stands still (once near the Earth);
    H = p cosB + Z sinB - a sqrt(1 - e^2 sin^2 B). On the axis L = 0. Within some 45 km of the Earth's centre the normal
    is not unique and B has no meaning. Source: B. R. Bowring, 1976.
    """
    return _geographic(XYZ, np.transpose, ellipsoid)


def _geographic(given: ArrayLike, geocentric: Callable[[Array], Array], ellipsoid: Ellipsoid) -> Array:
    """B, L, H of points (..., 3), some thousand at a time; `geocentric` makes their X, Y, Z (3, k) from rows (k, 3)."""
    points = np.asarray(given, dtype=np.float64)
    rows = points.reshape(-1, 3)
    found = np.empty_like(rows)
    for begin in range(0, len(rows), POINTS_AT_ONCE):
        part = slice(begin, begin + POINTS_AT_ONCE)
        X, Y, Z = geocentric(rows[part])
        p = np.sqrt(X * X + Y * Y)
        sin_B, cos_B = _latitude(p, Z, ellipsoid)
        np.arctan2(sin_B, cos_B, out=found[part, 0])
        np.arctan2(Y, X, out=found[part, 1])
        p *= cos_B
        p += Z * sin_B
        np.subtract(p, ellipsoid.a_m * np.sqrt(1.0 - (ellipsoid.e2 * sin_B) * sin_B), out=found[part, 2])
    return found.reshape(points.shape)


def _latitude(p: Array, Z: Array, ellipsoid: Ellipsoid) -> tuple[Array, Array]:
    """sin B, cos B by Bowring's formula, without a single angle.

    The formula is a step of Newton: it leaves about e^2 a/(M + H) of the square of what it moved B by, and M + H is
    the length of its numerator and denominator. It begins at the latitude for H/N = k - 1, k^2 = p^2/a^2 + Z^2/b^2,
    within 2e-8 of B up to 9 km above the Earth, so that one step is enough.
    """
    a, b, e2 = ellipsoid.a_m, ellipsoid.b_m, ellipsoid.e2
    k = np.sqrt((p * p) * (1.0 / (a * a)) + (Z * Z) * (1.0 / (b * b)))
    # of beta, to be scaled; deep inside, where k says nothing of H, any start on the right side will do
    sine, cosine = (b * k) * Z, (a * np.maximum(k - e2, 0.5 * (1.0 - e2))) * p
    for _ in range(LATITUDE_STEPS):
        _to_unit_length(sine, cosine)
        sin_B, cos_B = sine * sine * sine, cosine * cosine * cosine
        sin_B *= ellipsoid.ep2 * b
        sin_B += Z
        cos_B *= -e2 * a
        cos_B += p
        size = _to_unit_length(sin_B, cos_B)
        cosine *= b / a
        moved = sin_B * cosine - cos_B * sine  # sin(B - B before), nearly
        moved *= moved
        moved *= size
        if np.max(moved, initial=0.0) * (NEWTON * e2 * a) <= STANDS_STILL:
            break
        sine, cosine = b * sin_B, a * cos_B
    return sin_B, cos_B


def _to_unit_length(sine: Array, cosine: Array) -> Array:
    """Sine and cosine of something, in place, and what they were multiplied by."""
    size = sine * sine
    size += cosine * cosine
    np.maximum(size, SMALLEST, out=size)
    np.sqrt(size, out=size)
    np.divide(1.0, size, out=size)
    sine *= size
    cosine *= size
    return size


def local_axes(B: ArrayLike, L: ArrayLike) -> Array:
    """Columns north, east, up of the horizon at B, L [rad], in the geocentric system: (..., 3, 3), det = -1."""
    B, L = np.broadcast_arrays(np.asarray(B, dtype=np.float64), np.asarray(L, dtype=np.float64))
    sB, cB, sL, cL = np.sin(B), np.cos(B), np.sin(L), np.cos(L)
    north = np.stack([-sB * cL, -sB * sL, cB], axis=-1)
    east = np.stack([-sL, cL, np.zeros_like(sL)], axis=-1)
    up = np.stack([cB * cL, cB * sL, sB], axis=-1)
    return np.stack([north, east, up], axis=-1)


def horizon_axes(B: ArrayLike, L: ArrayLike, origin: Origin) -> Array:
    """A (n, 3, 3): A (dn, de, du) in the own horizon of each point B, L (n,) [rad] = (dX, dY, dZ) in T of the origin.

    Covariances follow as A K A'. For a standard deviation in B use dn = (M + H) dB, in L de = (N + H) cosB dL.
    """
    result: Array = local_axes(origin.B, origin.L).T @ local_axes(B, L)
    return result


def turn_to_grid(T: ArrayLike, gamma: float) -> Array:
    """T' = T turned by the convergence: X' = X cos g + Y sin g, Y' = -X sin g + Y cos g, Z' = Z: (n, 3) [m].

    gamma > 0 [rad]: grid north lies east of true north (northern hemisphere, east of the central meridian).
    """
    return np.asarray(T, dtype=np.float64) @ turn(gamma).T


def turn_from_grid(T_grid: ArrayLike, gamma: float) -> Array:
    """T of T' (n, 3) [m]: X = X' cos g - Y' sin g, Y = X' sin g + Y' cos g; inverse of `turn_to_grid`."""
    return np.asarray(T_grid, dtype=np.float64) @ turn(gamma)


def turn(gamma: float) -> Array:
    """G (3, 3) with T' = G T."""
    c, s = np.cos(gamma), np.sin(gamma)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
