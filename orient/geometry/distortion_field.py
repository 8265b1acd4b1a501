"""d(x, y) = (x g(r^2) + decentring + thin prism): the vector field of lens distortion, whatever its direction.

    dx = x g + p1 (r^2 + 2 x^2) + 2 p2 x y + s1 r^2 + s2 r^4
    dy = y g + p2 (r^2 + 2 y^2) + 2 p1 x y + s3 r^2 + s4 r^4

x right, y up, from the principal point. D. C. Brown 1966/1971. The OpenCV model is the same field in the normalised
coordinates x/f, y/f with g rational; its y points down, its p1 and p2 are exchanged: `opencv_coefficients` undoes that.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError

Array = NDArray[np.float64]
Radial = Callable[[Array], tuple[Array, Array]]
"""r (n,) -> g(r), dg/dr: the radial distortion is r g(r)."""

BROWN_NAMES = ("k0", "k1", "k2", "k3", "p1", "p2", "s1", "s2", "s3", "s4")
OPENCV_NAMES = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4")


def brown_radial(coefficients: Mapping[str, float]) -> Radial:
    """g = k0 + k1 r^2 + k2 r^4 + k3 r^6, r in mm."""
    k0, k1, k2, k3 = (coefficients.get(name, 0.0) for name in ("k0", "k1", "k2", "k3"))

    def radial(r: Array) -> tuple[Array, Array]:
        s = r * r
        return k0 + s * (k1 + s * (k2 + s * k3)), 2.0 * r * (k1 + s * (2.0 * k2 + 3.0 * s * k3))

    return radial


def opencv_radial(coefficients: Mapping[str, float]) -> Radial:
    """g = (1 + k1 r^2 + k2 r^4 + k3 r^6)/(1 + k4 r^2 + k5 r^4 + k6 r^6) - 1, r = |(x, y)|/f."""
    k1, k2, k3, k4, k5, k6 = (coefficients.get(f"k{i}", 0.0) for i in range(1, 7))

    def radial(r: Array) -> tuple[Array, Array]:
        s = r * r
        top, bottom = s * (k1 + s * (k2 + s * k3)), s * (k4 + s * (k5 + s * k6))
        top_by_s, bottom_by_s = k1 + s * (2 * k2 + 3 * s * k3), k4 + s * (2 * k5 + 3 * s * k6)
        with np.errstate(divide="ignore", invalid="ignore"):
            g = (top - bottom) / (1.0 + bottom)
            g_by_s = (top_by_s - bottom_by_s * (1.0 + g)) / (1.0 + bottom)
        return g, 2.0 * r * g_by_s

    return radial


def opencv_coefficients(coefficients: Mapping[str, float]) -> dict[str, float]:
    """p1 = p2(cv), p2 = -p1(cv), s3 = -s3(cv), s4 = -s4(cv): OpenCV's tangential part for y up and Brown's letters."""
    c = {name: coefficients.get(name, 0.0) for name in ("p1", "p2", "s1", "s2", "s3", "s4")}
    return {"p1": c["p2"], "p2": -c["p1"], "s1": c["s1"], "s2": c["s2"], "s3": -c["s3"], "s4": -c["s4"]}


def table_radial(table: Array) -> Radial:
    """g = D(r)/r of a camera certificate, table (k, 2) = r, D(r) in mm, r growing; D is linear between the rows.

    D(0) = 0 is added if the table starts later. A radius beyond the last row raises GeometryError: nothing is
    extrapolated.
    """
    rows = table if table[0, 0] == 0.0 else np.vstack([[0.0, 0.0], table])
    radii, values = rows.T
    slopes = np.diff(values) / np.diff(radii)

    def radial(r: Array) -> tuple[Array, Array]:
        if np.any(r > radii[-1]):
            raise GeometryError(
                f"distortion: the radial table ends at {radii[-1]:g} mm, a point lies at {np.max(r):.3f} mm",
                "Add the missing radii of the certificate, or leave the point out.",
            )
        index = np.clip(np.searchsorted(radii, r, side="right") - 1, 0, len(slopes) - 1)
        slope, at_row = slopes[index], values[index]
        with np.errstate(divide="ignore", invalid="ignore"):
            g = np.where(r > 0.0, (at_row + slope * (r - radii[index])) / r, slope)
            g_by_r = np.where(r > 0.0, (slope - g) / r, 0.0)
        return g, g_by_r

    return radial


def field(radial: Radial, coefficients: Mapping[str, float], xy: Array) -> tuple[Array, Array]:
    """d(x, y) (n, 2) and its Jacobian dd/d(x, y) (n, 2, 2) at xy (n, 2), by the two equations of this module."""
    p1, p2, s1, s2, s3, s4 = (coefficients.get(name, 0.0) for name in ("p1", "p2", "s1", "s2", "s3", "s4"))
    x, y = xy.T
    s = x * x + y * y
    r = np.sqrt(s)
    g, g_by_r = radial(r)
    dx = x * g + p1 * (s + 2 * x * x) + 2 * p2 * x * y + s * (s1 + s * s2)
    dy = y * g + p2 * (s + 2 * y * y) + 2 * p1 * x * y + s * (s3 + s * s4)
    with np.errstate(divide="ignore", invalid="ignore"):
        h = np.where(r > 0.0, g_by_r / r, 0.0)  # x y/r -> 0 at the principal point, whatever g' is there
    prism_x, prism_y = s1 + 2 * s * s2, s3 + 2 * s * s4
    jacobian = np.empty((len(xy), 2, 2))
    jacobian[:, 0, 0] = g + h * x * x + 6 * p1 * x + 2 * p2 * y + 2 * x * prism_x
    jacobian[:, 0, 1] = h * x * y + 2 * p1 * y + 2 * p2 * x + 2 * y * prism_x
    jacobian[:, 1, 0] = h * x * y + 2 * p2 * x + 2 * p1 * y + 2 * x * prism_y
    jacobian[:, 1, 1] = g + h * y * y + 6 * p2 * y + 2 * p1 * x + 2 * y * prism_y
    return np.stack([dx, dy], axis=-1), jacobian


def coefficient_partials(names: Sequence[str], xy: Array) -> Array:
    """d(dx, dy)/dc (n, 2, m) of k1 k2 k3 p1 p2 in Brown's letters, at xy (n, 2): the field is linear in them."""
    x, y = xy.T
    s = x * x + y * y
    columns = {
        "k1": xy * s[:, None],
        "k2": xy * (s * s)[:, None],
        "k3": xy * (s * s * s)[:, None],
        "p1": np.stack([s + 2 * x * x, 2 * x * y], axis=-1),
        "p2": np.stack([2 * x * y, s + 2 * y * y], axis=-1),
    }
    return np.stack([columns[name] for name in names], axis=-1) if names else np.zeros((len(xy), 2, 0))
