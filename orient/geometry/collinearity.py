"""Collinearity: (xs, ys, zs) = R'(P - S); x = -f xs/zs, y = -f ys/zs; zs < 0 in front of the camera.

R = ground_from_image, right-handed ground frame. x right, y up, from the principal point, in the unit of f;
P, S, zs in the ground's unit. Partials are of the COMPUTED coordinates: v = A d + L, L = computed - measured.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.geometry.rotation import aok_from_matrix

Array = NDArray[np.float64]


def camera_coordinates(ground: ArrayLike, station: ArrayLike, rotation: ArrayLike) -> Array:
    """(xs, ys, zs) = R'(P - S): (n, 3) in the ground's unit, along the image axes."""
    arms: Array = np.asarray(ground, dtype=np.float64) - np.asarray(station, dtype=np.float64)
    result: Array = arms @ np.asarray(rotation, dtype=np.float64)
    return result


def project(ground: ArrayLike, station: ArrayLike, rotation: ArrayLike, f: float) -> tuple[Array, Array]:
    """x = -f xs/zs, y = -f ys/zs with (xs, ys, zs) = R'(P - S).

    `ground` (n, 3) and `station` (3,) in metres, `rotation` R (3, 3), `f` in the unit wanted for the image.
    Returns the image coordinates (n, 2) and zs (n,). A point is in front of the camera only if zs < 0; a point behind
    it has an image by the formula too, and one with zs = 0 lies at infinity (inf or nan): the caller looks at zs.
    Source: seed 004 (3) corrected, EQUATIONS 4.3.
    """
    camera = camera_coordinates(ground, station, rotation)
    zs = camera[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        image: Array = -f * camera[:, :2] / zs[:, None]
    return image, zs


def partials_aok(ground: ArrayLike, station: ArrayLike, rotation: ArrayLike, f: float) -> Array:
    """d(x, y)/d(alpha, omega, kappa, XS, YS, ZS, X, Y, Z): (n, 2, 9), the nine coefficients A1..A9, B1..B9.

        dx/dal = -f b2 - b3 y + (x/f)(b1 y - b2 x)          dy/dal = f b1 + b3 x + (y/f)(b1 y - b2 x)
        dx/dom = -f sin(ka) - (x/f)(x sin(ka) + y cos(ka))  dy/dom = -f cos(ka) - (y/f)(x sin(ka) + y cos(ka))
        dx/dka = y                                          dy/dka = -x
        d(x, y)/dS as in `partials_station`;                A7 = -A4, A8 = -A5, A9 = -A6

    Arguments as in `project`; angles in radians. Undefined for zs = 0. Source: seed 004 (4), EQUATIONS 4.3.
    """
    R = np.asarray(rotation, dtype=np.float64)
    image, zs = project(ground, station, R, f)
    x, y = image.T
    b1, b2, b3 = R[1]
    kappa = aok_from_matrix(R)[2]
    sk, ck = np.sin(kappa), np.cos(kappa)
    p, q = (b1 * y - b2 * x) / f, (x * sk + y * ck) / f
    by_alpha = np.stack([-f * b2 - b3 * y + x * p, f * b1 + b3 * x + y * p], axis=-1)
    by_omega = np.stack([-f * sk - x * q, -f * ck - y * q], axis=-1)
    by_kappa = np.stack([y, -x], axis=-1)
    by_angles = np.stack([by_alpha, by_omega, by_kappa], axis=-1)
    by_station = partials_station(image, zs, R, f)
    return np.concatenate([by_angles, by_station, -by_station], axis=-1)


def partials_rotation(ground: ArrayLike, station: ArrayLike, rotation: ArrayLike, f: float) -> Array:
    """d(x, y)/d(r1, r2, r3, XS, YS, ZS, X, Y, Z): (n, 2, 9), for R_new = exp([r]x) R at r = 0.

        d(xs, ys, zs)/dr = R' [P - S]x,  d(x, y)/dr = d(x, y)/dP [P - S]x

    Free of blind views: there is no angle in it. Arguments as in `project`; undefined for zs = 0.
    """
    return projected_with_partials(ground, station, rotation, f)[1]


def projected_with_partials(
    ground: ArrayLike, station: ArrayLike, rotation: ArrayLike, f: float
) -> tuple[Array, Array]:
    """The image coordinates (n, 2) of `project`, and of the same points the (n, 2, 9) of `partials_rotation`."""
    R = np.asarray(rotation, dtype=np.float64)
    image, zs = project(ground, station, R, f)
    arms = np.asarray(ground, dtype=np.float64) - np.asarray(station)
    partials = np.empty((len(image), 2, 9))
    partials[..., 3:6] = partials_station(image, zs, R, f)
    # -a [p]x = p x a, row by row
    partials[..., 0] = arms[:, None, 1] * partials[..., 5] - arms[:, None, 2] * partials[..., 4]
    partials[..., 1] = arms[:, None, 2] * partials[..., 3] - arms[:, None, 0] * partials[..., 5]
    partials[..., 2] = arms[:, None, 0] * partials[..., 4] - arms[:, None, 1] * partials[..., 3]
    partials[..., 6:] = -partials[..., 3:6]
    return image, partials


def partials_station(image: Array, zs: Array, rotation: Array, f: float) -> Array:
    """dx/dXS = (f a1 + x a3)/zs, dy/dXS = (f a2 + y a3)/zs; with b for YS, c for ZS: (n, 2, 3)."""
    rows = rotation.T
    numerator = f * rows[None, :2, :] + image[:, :, None] * rows[None, 2:, :]
    with np.errstate(divide="ignore", invalid="ignore"):
        result: Array = numerator / zs[:, None, None]
    return result


def image_ray(image: ArrayLike, rotation: ArrayLike, f: float) -> Array:
    """u = R (x, y, -f)/|(x, y, -f)|: (n, 3) unit directions from the station to the ground, in the ground frame.

    `image` (n, 2) in the unit of f. P = S + s u with s > 0 is every ground point seen at (x, y).
    """
    xy = np.asarray(image, dtype=np.float64)
    rays = np.column_stack([xy, np.full(len(xy), -f)])
    directions: Array = rays @ np.asarray(rotation, dtype=np.float64).T
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return directions
