"""Where a straight line meets the surface of a given height."""

import numpy as np
from numpy.typing import NDArray

from orient.geodesy.ellipsoid import Ellipsoid
from orient.geodesy.topocentric import geocentric_from_geographic, geographic_from_geocentric

Array = NDArray[np.float64]


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
