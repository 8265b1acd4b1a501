"""The topocentric system T = (X north, Y east, Z up) of an origin (B_N, L_N, H_N); T' = T turned by gamma about up.

T and T' are LEFT-handed, as in the seed. B, L are geodetic latitude and longitude in radians (L positive east), H the
ELLIPSOIDAL height; lengths in metres. The origin of the papers is the nadir point on the physical surface, but any
point will do. Geocentric X, Y, Z are right-handed: X to B = L = 0, Z along the axis.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.geodesy.ellipsoid import Ellipsoid, prime_vertical_radius

Array = NDArray[np.float64]

Radius = Callable[[Ellipsoid, ArrayLike], Array]

LATITUDE_STEPS = 20
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
) -> Array:
    """T (n, 3) = (X north, Y east, Z up) [m] of points B, L [rad], H [m] (n,), by the closed formulas of seed 004 (2).

        X = (N+H) sin dB + nu cosB sinB_N - Q cosB_N
        Y = (N+H) cosB sin l
        Z = [N_N e'^2 sin dB sin(B+B_N)/(V (V_N+V)) + H - H_N] cos dB - 2 (N_N+H_N) sin^2(dB/2)
            - nu cosB cosB_N - Q sinB_N

    dB = B - B_N, l = L - L_N, V = sqrt(1 + e'^2 cos^2 B), Q = e^2 (N sinB - N_N sinB_N), nu = 2 (N+H) sin^2(l/2).
    Corrected as in EQUATIONS 4 (H - H_N; N from the point's own latitude; Y' and X' of the paper are X and Y here).
    Exact at any distance, on any ellipsoid, at the poles and across the date line (l enters only as sine). `radius`
    gives N: exact, or the paper's `prime_vertical_polynomial`.
    """
    B, L, H = np.broadcast_arrays(*(np.asarray(value, dtype=np.float64) for value in (B, L, H)))
    if B.ndim != 1 or len(B) <= POINTS_AT_ONCE:
        return _topocentric(B, L, H, origin, ellipsoid, radius)
    parts = [slice(begin, begin + POINTS_AT_ONCE) for begin in range(0, len(B), POINTS_AT_ONCE)]
    T = np.empty((len(B), 3))
    for part in parts:
        T[part] = _topocentric(B[part], L[part], H[part], origin, ellipsoid, radius)
    return T


def _topocentric(B: Array, L: Array, H: Array, origin: Origin, ellipsoid: Ellipsoid, radius: Radius) -> Array:
    B_N, dB, l = origin.B, B - origin.B, L - origin.L
    N, N_N = radius(ellipsoid, B), radius(ellipsoid, B_N)
    sin_B, cos_B, sin_dB, sin_half = np.sin(B), np.cos(B), np.sin(dB), np.sin(dB / 2.0)
    V, V_N = (np.sqrt(1.0 + ellipsoid.ep2 * cosine**2) for cosine in (cos_B, np.cos(np.float64(B_N))))
    nu = 2.0 * (N + H) * np.sin(l / 2.0) ** 2
    dN = N_N * ellipsoid.ep2 * sin_dB * np.sin(B + B_N) / (V * (V_N + V))  # = N - N_N without cancellation
    Q = ellipsoid.e2 * (dN * sin_B + 2.0 * N_N * np.cos((B + B_N) / 2.0) * sin_half)
    X = (N + H) * sin_dB + nu * cos_B * np.sin(B_N) - Q * np.cos(B_N)
    Y = (N + H) * cos_B * np.sin(l)
    Z = (
        (dN + H - origin.H) * np.cos(dB)
        - 2.0 * (N_N + origin.H) * sin_half**2
        - nu * cos_B * np.cos(B_N)
        - Q * np.sin(B_N)
    )
    return np.stack([X, Y, Z], axis=-1)


def geographic_from_topocentric(T: ArrayLike, origin: Origin, ellipsoid: Ellipsoid) -> Array:
    """(B, L, H) (n, 3) [rad, rad, m] of T (n, 3) [m]: T -> geocentric -> geographic; inverse of the closed formulas."""
    axes = local_axes(origin.B, origin.L)
    at_origin = geocentric_from_geographic(origin.B, origin.L, origin.H, ellipsoid)
    return geographic_from_geocentric(at_origin + np.asarray(T, dtype=np.float64) @ axes.T, ellipsoid)


def geocentric_from_geographic(B: ArrayLike, L: ArrayLike, H: ArrayLike, ellipsoid: Ellipsoid) -> Array:
    """X = (N+H) cosB cosL, Y = (N+H) cosB sinL, Z = (N (1-e^2) + H) sinB: (n, 3) [m] of B, L [rad], H [m] (n,)."""
    B, L, H = (np.asarray(value, dtype=np.float64) for value in (B, L, H))
    N = prime_vertical_radius(ellipsoid, B)
    p = (N + H) * np.cos(B)
    return np.stack([p * np.cos(L), p * np.sin(L), (N * (1.0 - ellipsoid.e2) + H) * np.sin(B)], axis=-1)


def geographic_from_geocentric(XYZ: ArrayLike, ellipsoid: Ellipsoid) -> Array:
    """(B, L, H) (n, 3) [rad, rad, m] of geocentric XYZ (n, 3) [m].

        tan B = (Z + e'^2 b sin^3 beta)/(p - e^2 a cos^3 beta), tan beta = (b/a) tan B, p = sqrt(X^2 + Y^2)

    repeated until B stands still (two or three rounds near the Earth); H = p cosB + Z sinB - a sqrt(1 - e^2 sin^2 B).
    On the axis L = 0. Within some 45 km of the Earth's centre the normal is not unique and B has no meaning.
    Source: B. R. Bowring, 1976.
    """
    points = np.asarray(XYZ, dtype=np.float64)
    if points.ndim != 2 or len(points) <= POINTS_AT_ONCE:
        return _geographic(points, ellipsoid)
    found = np.empty_like(points)
    for begin in range(0, len(points), POINTS_AT_ONCE):
        part = slice(begin, begin + POINTS_AT_ONCE)
        found[part] = _geographic(points[part], ellipsoid)
    return found


def _geographic(XYZ: Array, ellipsoid: Ellipsoid) -> Array:
    X, Y, Z = np.moveaxis(XYZ, -1, 0)
    a, b, e2, ep2 = ellipsoid.a_m, ellipsoid.b_m, ellipsoid.e2, ellipsoid.ep2
    p = np.hypot(X, Y)
    beta = np.arctan2(a * Z, b * p)
    B = beta
    for _ in range(LATITUDE_STEPS):
        previous = B
        B = np.arctan2(Z + ep2 * b * np.sin(beta) ** 3, p - e2 * a * np.cos(beta) ** 3)
        beta = np.arctan2(b * np.sin(B), a * np.cos(B))
        if np.all(np.abs(B - previous) <= 4e-16):
            break
    H = p * np.cos(B) + Z * np.sin(B) - a * np.sqrt(1.0 - e2 * np.sin(B) ** 2)
    return np.stack([B, np.arctan2(Y, X), H], axis=-1)


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
