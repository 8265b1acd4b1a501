"""Where straight lines meet the surface of one height, or each its own height."""

import numpy as np
from numpy.typing import NDArray

from orient.geodesy.ellipsoid import Ellipsoid
from orient.geodesy.topocentric import geocentric_from_geographic, geographic_from_geocentric

Array = NDArray[np.float64]

NEWTON_STEPS = 4
"""Each squares the relative error of H f^2 / distance that the first meeting leaves; two already reach rounding."""


def line_at_height(start: Array, directions: Array, ellipsoid: Ellipsoid, height: float) -> Array:
    """P = S + t u: first point of each line at the height H above the ellipsoid, (n, 3) geocentric [m].

    The line is cut with the ellipsoid of semi-axes a + H, b + H, |D (S + t u)| = 1 with D = diag(1/a, 1/a, 1/b), and
    the point is put back to H along its normal: within H f^2 of the line, 0.1 m for 10 km. `start` S (3,), `directions`
    u (n, 3) of any length. NaN where the line passes above the surface, or has it behind S; S is above the surface.
    """
    a, b = ellipsoid.a_m + height, ellipsoid.b_m + height
    D = 1.0 / np.array([a, a, b])
    from_centre, u = start * D, directions * D
    uu, su = np.sum(u * u, axis=1), u @ from_centre
    with np.errstate(invalid="ignore"):
        t = (-su - np.sqrt(su * su - uu * (from_centre @ from_centre - 1.0))) / uu
    points = start + np.where(t > 0, t, np.nan)[:, None] * directions
    B, L, _ = geographic_from_geocentric(points, ellipsoid).T
    return geocentric_from_geographic(B, L, np.full(len(points), height), ellipsoid)


def line_at_heights(start: Array, directions: Array, ellipsoid: Ellipsoid, heights: Array) -> Array:
    """P = S + t u with the ellipsoidal height H_i, exactly on each line: (n, 3) geocentric [m].

    t from the ellipsoid of semi-axes a + H, b + H, then Newton's t += (H - H(P)) / (n . u), n the normal at P.
    Arguments and NaN as in `line_at_height`, with `heights` (n,).
    """
    semi_axes = np.stack([ellipsoid.a_m + heights, ellipsoid.a_m + heights, ellipsoid.b_m + heights], axis=-1)
    from_centre, u = start / semi_axes, directions / semi_axes
    uu, su = np.sum(u * u, axis=1), np.sum(u * from_centre, axis=1)
    with np.errstate(invalid="ignore"):
        t = (-su - np.sqrt(su * su - uu * (np.sum(from_centre**2, axis=1) - 1.0))) / uu
    t = np.where(t > 0, t, np.nan)
    for _ in range(NEWTON_STEPS):
        B, L, H = geographic_from_geocentric(start + t[:, None] * directions, ellipsoid).T
        normal = np.stack([np.cos(B) * np.cos(L), np.cos(B) * np.sin(L), np.sin(B)], axis=-1)
        with np.errstate(divide="ignore", invalid="ignore"):
            t = t + (heights - H) / np.sum(normal * directions, axis=1)
    return np.asarray(start + t[:, None] * directions)
