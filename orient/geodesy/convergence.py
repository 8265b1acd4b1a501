"""Meridian convergence gamma: the angle from true north to grid north in a Gauss-Krueger (transverse Mercator) zone.

gamma > 0: grid north lies EAST of true north (northern hemisphere, east of the central meridian). Radians.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.geodesy.ellipsoid import Ellipsoid

Array = NDArray[np.float64]


def convergence(B: ArrayLike, L: ArrayLike, central_meridian: float, ellipsoid: Ellipsoid) -> Array:
    """gamma = arctan{ { [(l^2 + 2e'^2/3) cos^2 B + 1] e'^2 l^3 cos^4 B + tan l } sin B } [rad].

    l = L - L_0 with L_0 the central meridian of the map zone (not the nadir's longitude), taken in (-pi, pi]. B, L in
    radians, any shape. Within 0.0001" of the rigorous value for |l| <= 6 deg, 0.006" for 12 deg; meaningless beyond
    some 30 deg. Exact on a sphere (e'^2 = 0). The paper prints e'^2 and 2e'^2/3 of the Krasovsky ellipsoid as 0.00674
    and 0.0045. Source: seed 004, EQUATIONS 4.
    """
    B, L = np.asarray(B, dtype=np.float64), np.asarray(L, dtype=np.float64)
    l = np.remainder(L - central_meridian + np.pi, 2.0 * np.pi) - np.pi
    ep2, c2 = ellipsoid.ep2, np.cos(B) ** 2
    bracket = (l**2 + 2.0 * ep2 / 3.0) * c2 + 1.0
    result: Array = np.arctan((bracket * ep2 * l**3 * c2**2 + np.tan(l)) * np.sin(B))
    return result
