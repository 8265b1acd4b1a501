"""(u', w') = lens of OpenCV of (u, w): coefficients in OpenCV's order, from a lens of orient or fitted to one.

    q  = s (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)
    u' = u q + s (2 p1 u w + p2 (r^2 + 2 u^2) + s1 r^2 + s2 r^4)
    w' = w q + s (p1 (r^2 + 2 w^2) + 2 p2 u w + s3 r^2 + s4 r^4)

u along the columns, w along the rows, divided by the focal length; the scale s goes into the focal length of K.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.geometry.distortion import Distortion

Array = NDArray[np.float64]

NAMES = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4")
"""OpenCV's order of its first twelve coefficients."""
FITTED = ("k1", "k2", "k3", "p1", "p2", "s1", "s2", "s3", "s4")
DENOMINATOR = ("k4", "k5", "k6")
SIDEWAYS = ("p1", "p2", "s1", "s2", "s3", "s4")
"""Terms of even degree: they change their sign when both axes are reversed."""


@dataclass(frozen=True, slots=True)
class OpencvLens:
    """Coefficients (12,) in the order of `NAMES`, and the scale s of the focal length."""

    coefficients: Array
    scale: float = 1.0


def converted(lens: Distortion, f_mm: float, axes: Array) -> OpencvLens | None:
    """The same lens exactly; None where its definition leads from measured to ideal positions, or is a table.

    brown, from ideal to distorted, x = f u, y = -f w: k_i f^2i, p1 <- -p2 f, p2 <- p1 f, s1 f, s2 f^3, -s3 f, -s4 f^3,
    all divided by s = 1 + k0. `axes` (2,): the directions of u and w along x and y, (1, -1) or (-1, 1).
    """
    if lens.model == "none":
        return OpencvLens(np.zeros(len(NAMES)))
    if lens.direction != "ideal_to_distorted" or lens.model == "radial_table":
        return None
    given = lens.coefficients
    if lens.model == "opencv":
        return OpencvLens(_ordered(given, axes))
    s = 1.0 + given.get("k0", 0.0)
    of = {name: given.get(name, 0.0) for name in ("k1", "k2", "k3", "p1", "p2", "s1", "s2", "s3", "s4")}
    named = {
        **{f"k{i}": of[f"k{i}"] * f_mm ** (2 * i) / s for i in (1, 2, 3)},
        "p1": -of["p2"] * f_mm / s,
        "p2": of["p1"] * f_mm / s,
        "s1": of["s1"] * f_mm / s,
        "s2": of["s2"] * f_mm**3 / s,
        "s3": -of["s3"] * f_mm / s,
        "s4": -of["s4"] * f_mm**3 / s,
    }
    return OpencvLens(_ordered(named, axes), s)


def fitted(ideal: Array, distorted: Array, *, rational: bool = False) -> OpencvLens:
    """The lens that takes `ideal` (n, 2) to `distorted` (n, 2) best, both along u, w and divided by f: least squares.

    The equations are linear in s and the products s k1, ...; `rational` adds k4, k5, k6 after Levy (1959): both sides
    times the denominator, which is near 1.
    """
    names = (*FITTED, *DENOMINATOR) if rational else FITTED
    columns = [ideal.T.ravel(), *(_term(name, ideal, distorted).T.ravel() for name in names)]
    A = np.column_stack(columns)
    size = np.linalg.norm(A, axis=0)
    found = np.linalg.lstsq(A / size, distorted.T.ravel(), rcond=None)[0] / size
    scale = float(found[0])
    named = {
        name: float(value) if name in DENOMINATOR else float(value) / scale
        for name, value in zip(names, found[1:], strict=True)
    }
    return OpencvLens(_ordered(named, np.array([1.0, -1.0])), scale)


def _term(name: str, ideal: Array, distorted: Array) -> Array:
    """(n, 2): what one coefficient multiplies, along u and along w."""
    u, w = ideal.T
    r2 = u * u + w * w
    zero, power = np.zeros_like(u), int(name[1:])
    if name in DENOMINATOR:
        return np.asarray(-distorted * r2[:, None] ** (power - 3))
    if name[0] == "k":
        return np.asarray(ideal * r2[:, None] ** power)
    if name[0] == "s":
        term = r2 ** (2 - power % 2)
        return np.column_stack([term, zero] if power <= 2 else [zero, term])
    if name == "p1":
        return np.column_stack([2 * u * w, r2 + 2 * w * w])
    return np.column_stack([r2 + 2 * u * u, 2 * u * w])


def distorted(lens: OpencvLens, ideal: Array) -> Array:
    """(n, 2) of `ideal` (n, 2), both along u, w and divided by f."""
    k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 = lens.coefficients.tolist()
    u, w = ideal.T
    r2 = u * u + w * w
    q = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
    along_u = u * q + 2 * p1 * u * w + p2 * (r2 + 2 * u * u) + r2 * (s1 + r2 * s2)
    along_w = w * q + p1 * (r2 + 2 * w * w) + 2 * p2 * u * w + r2 * (s3 + r2 * s4)
    return np.asarray(lens.scale * np.column_stack([along_u, along_w]))


def _ordered(named: Mapping[str, float], axes: Array) -> Array:
    sign = float(axes[0])
    return np.array([named.get(name, 0.0) * (sign if name in SIDEWAYS else 1.0) for name in NAMES])
