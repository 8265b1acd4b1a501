"""[A_P; n'] dP = [dx - A_e de; dH]: how sure is the ground point where an image ray meets its height.

A_P, A_e: partials of the image coordinates by the point and by the six elements; n: the point's own vertical. The
solution dP = C de + J dx + h dH splits the covariance into the parts of orientation K = C Q C', reading and height.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from orient.geometry.collinearity import image_ray, partials_rotation
from orient.geometry.rotation import cross_matrix

FloatArray = NDArray[np.float64]

GRAZING_SINE = 1e-6
POINTS_AT_ONCE = 4096
"""Points whose intermediate numbers stay in the processor's cache."""
STRIP = 32
"""Rows of all pairs at once: a multiple of what the kernels of OpenBLAS take, which are 2 to 32 entries wide."""


@dataclass(frozen=True, slots=True)
class RayJacobians:
    """dP = C de + J dx + h dH of n points: C (n, 3, u), J (n, 3, 2) [m/mm], h (n, 3); NaN where a ray is level."""

    C: FloatArray
    J: FloatArray
    h: FloatArray

    @property
    def determined(self) -> NDArray[np.bool_]:
        """Points (n,) whose ray meets the height."""
        return np.asarray(np.isfinite(self.h).all(axis=1))

    def at(self, keep: Sequence[int]) -> "RayJacobians":
        """Those of the points at these places of the list."""
        return RayJacobians(self.C[keep], self.J[keep], self.h[keep])


@dataclass(frozen=True, slots=True)
class GroundCovariance:
    """Parts of the covariance (n, 3, 3) [m^2] of the ground points, in the frame of the orientation."""

    orientation: FloatArray
    reading: FloatArray
    height: FloatArray

    @property
    def total(self) -> FloatArray:
        """Sum of the three parts, which are independent."""
        return self.orientation + self.reading + self.height


def ray_at_height(
    image: FloatArray, station: FloatArray, rotation: FloatArray, f_mm: float, heights: FloatArray, up: FloatArray
) -> FloatArray:
    """P = S + u (n . (P0 - S)) / (n . u): where the image rays meet the level planes of their heights, (n, 3) [m].

    `image` (n, 2) [mm] refined; `heights` P0 (n, 3): any point of each level plane, right-handed ground frame; `up`
    n (n, 3): unit verticals. NaN where the ray runs level within 1e-6 or meets the plane behind the camera.
    """
    rays = image_ray(image, rotation, f_mm)
    fall = np.sum(up * rays, axis=1)
    drop = np.sum(up * (heights - station), axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = drop / fall
    meets = (np.abs(fall) > GRAZING_SINE) & (distance > 0)
    return np.asarray(station + np.where(meets, distance, np.nan)[:, None] * rays)


def ray_at_height_jacobians(
    points: FloatArray, station: FloatArray, rotation: FloatArray, f_mm: float, up: FloatArray
) -> RayJacobians:
    """dP = M [dx - A_e de; dH], M = [A_P; n']^-1: partials of the ground points by elements, reading and height.

    `points` (n, 3) on their rays (`ray_at_height`), `up` (n, 3) unit verticals. Elements e = (r, X_S, Y_S, Z_S) with
    R_new = exp([r]x) R. Source: seed 003, equations (1)-(2), without its assumption of a vertical photo.
    """
    found = RayJacobians(*(np.empty((len(points), 3, *last)) for last in ((6,), (2,), ())))
    for begin in range(0, len(points), POINTS_AT_ONCE):
        part = slice(begin, begin + POINTS_AT_ONCE)
        found.C[part], found.J[part], found.h[part] = _jacobians(points[part], station, rotation, f_mm, up[part])
    return found


def _jacobians(
    points: FloatArray, station: FloatArray, rotation: FloatArray, f_mm: float, up: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """M = (b x n, n x a, a x b) / a . (b x n) of the rows a, b of A_P: C, J, h."""
    partials = partials_rotation(points, station, rotation, f_mm)
    a, b, n = partials[:, 0, 6:].T, partials[:, 1, 6:].T, up.T
    with np.errstate(invalid="ignore", divide="ignore"):
        rays = points - station
        level = ~(np.abs(np.sum(up * rays, axis=1)) > GRAZING_SINE * np.linalg.norm(rays, axis=1))
        columns = _cross(b, n), _cross(n, a), _cross(a, b)
        M = np.stack(columns) / np.where(level, np.nan, np.sum(a * columns[0], axis=0))
    by_x, by_y = partials[:, 0, :6].T, partials[:, 1, :6].T
    C = -(M[0][:, None] * by_x + M[1][:, None] * by_y)
    return C.transpose(2, 0, 1), M[:2].transpose(2, 1, 0), M[2].T


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """a x b (3, n) of vectors by component."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def ground_covariance(
    jacobians: RayJacobians, element_covariance: FloatArray, reading_covariance: FloatArray, height_variance: FloatArray
) -> GroundCovariance:
    """K = C Q C', J Q_x J', h sigma_H^2 h': the three parts of the covariance of the ground points.

    `element_covariance` (u, u) full: six elements in rad and m, then those of the camera;
    `reading_covariance` (n, 2, 2) [mm^2]; `height_variance` (n,) [m^2].
    Never use the diagonal of Q alone: position and rotation are strongly correlated (seed 003, last recommendation).
    """
    reading = jacobians.J @ reading_covariance @ jacobians.J.transpose(0, 2, 1)
    height = height_variance[:, None, None] * jacobians.h[:, :, None] * jacobians.h[:, None, :]
    return GroundCovariance(orientation_covariance(jacobians, element_covariance), reading, height)


def orientation_covariance(
    jacobians: RayJacobians, element_covariance: FloatArray, *, compiled: bool = False
) -> FloatArray:
    """K_i = F_i F_i', F_i = C_i L, L L' = Q (u, u): the part of the orientation (n, 3, 3) [m^2], exactly symmetric.

    Row by row of F, some thousand points at a time: no small matrices are multiplied. `compiled`: by numba (extra
    `orient[fast]`), the same to 1e-9; no stage asks for it.
    """
    n, rows = jacobians.C.shape[:2]
    L = symmetric_factor(element_covariance)
    K = np.empty((n, rows, rows))
    if compiled:
        _compiled_products(jacobians.C, L, K)
        return K
    for begin in range(0, n, POINTS_AT_ONCE):
        part = slice(begin, begin + POINTS_AT_ONCE)
        F = [L.T @ jacobians.C[part, row].T for row in range(rows)]
        for i in range(rows):
            for j in range(i + 1):
                K[part, i, j] = K[part, j, i] = np.sum(F[i] * F[j], axis=0)
    return K


def _compiled_products(C: FloatArray, L: FloatArray, K: FloatArray) -> None:
    """Two rows at a time, some thousand points so that C is read once."""
    from orient.solvers.ground_kernel import products_of_rows

    products = products_of_rows(len(L))
    L = np.ascontiguousarray(L)
    pairs = list(combinations(range(K.shape[1]), 2)) or [(0, 0)]
    for begin in range(0, len(C), POINTS_AT_ONCE):
        part = np.ascontiguousarray(C[begin : begin + POINTS_AT_ONCE])
        for r, q in pairs:
            products(part, L, r, q, K[begin : begin + POINTS_AT_ONCE])


def covariance_factor(jacobians: RayJacobians, element_covariance: FloatArray) -> FloatArray:
    """F_i = C_i L with L L' = Q (n, 3, u): the covariance between points i and j through the orientation is F_i F_j'.

    The factor loses no digits to the strong correlations of Q, and serves all n^2 pairs.
    """
    C = jacobians.C
    return np.asarray((C.reshape(-1, C.shape[2]) @ symmetric_factor(element_covariance)).reshape(C.shape))


def all_pairs(factor: FloatArray) -> FloatArray:
    """K = F F' (m, m) of the rows F (m, u) of all points, symmetric to the last bit.

    No product promises that, because the place of an entry may decide the order in which it is summed. So strips of
    equal height are computed, each in the processor's cache, and one is compared with its mirror image. Where numbers
    show the order, they agree only if row and column modulo `STRIP` decide it, and both alike: then all of K agrees
    with its mirror image. The strip is that of the largest row, because zeros show nothing. What is left is mirrored.
    """
    factor = np.ascontiguousarray(factor)
    m, F_T = len(factor), np.ascontiguousarray(factor.T)
    K, whole = np.empty((m, m)), m - m % STRIP
    for begin in range(0, whole, STRIP):
        np.matmul(factor[begin : begin + STRIP], F_T, out=K[begin : begin + STRIP])
    if whole:
        largest = int(np.argmax(np.abs(factor[:whole]).sum(axis=1)))
        strip = slice(largest - largest % STRIP, largest - largest % STRIP + STRIP)
        if not np.array_equal(K[strip, :whole], K[:whole, strip].T):
            _mirror_upper_part(K[:whole, :whole])
    rest = factor[whole:]
    K[whole:, :whole] = rest @ F_T[:, :whole]
    K[:whole, whole:] = K[whole:, :whole].T
    K[whole:, whole:] = rest @ rest.T
    return K


def _mirror_upper_part(K: FloatArray) -> None:
    for begin in range(len(K)):
        K[begin:, begin] = K[begin, begin:]


def covariance_by_orientation(
    points: FloatArray,
    station: FloatArray,
    element_covariance: FloatArray,
    up: FloatArray,
    *,
    plan: bool = False,
    compiled: bool = False,
) -> FloatArray:
    """K_i = F_i F_i' (n, 3, 3) [m^2] of the part of the orientation, without the partials in between.

        dP = (1 - h n') (dS + r x (P - S)),  h = (P - S)/(n . (P - S)),  F = that of the columns of L, L L' = Q

    A turn r and a shift dS move the point; back along its ray it meets its level plane, normal n = `up` (3,) or (n, 3).
    Neither f nor R enters. The same as `orientation_covariance` of `ray_at_height_jacobians`, also NaN where a ray is
    level, with a tenth of the memory. `element_covariance` (6, 6) of (r, S), `points` (n, 3) [m].
    `plan`: only the first two coordinates, (n, 2, 2). `compiled`: by numba (extra `orient[fast]`), the same to 1e-9.
    """
    L, rows = symmetric_factor(element_covariance), 2 if plan else 3
    K = np.empty((len(points), rows, rows))
    if compiled:
        _compiled_covariances(points, station, L, up, K)
        return K
    turns = cross_matrix(L[:3].T).transpose(1, 0, 2).reshape(-1, 3)  # row (i, k): component i of r_k x arm
    for begin in range(0, len(points), POINTS_AT_ONCE):
        part = slice(begin, begin + POINTS_AT_ONCE)
        arms = points[part].T - station[:, None]
        normals = np.broadcast_to(up, points.shape)[part].T
        F = (turns @ arms).reshape(3, L.shape[1], -1) + L[3:, :, None]
        w = np.einsum("im,ikm->km", normals, F)
        F[:rows] -= _along_ray(arms, normals)[:rows, None] * w
        for i in range(rows):
            for j in range(i + 1):
                K[part, i, j] = K[part, j, i] = np.einsum("km,km->m", F[i], F[j])
    return K


def _compiled_covariances(
    points: FloatArray, station: FloatArray, L: FloatArray, up: FloatArray, K: FloatArray
) -> None:
    from orient.solvers.ground_kernel import covariances

    P, S, n, L = (np.ascontiguousarray(array) for array in (points, station, np.atleast_2d(up), L))
    covariances(P, S, L, n, GRAZING_SINE, K)


def _along_ray(arms: FloatArray, normals: FloatArray) -> FloatArray:
    """h (3, m): what one metre of height moves a point along its ray; NaN where the ray is level."""
    fall = np.einsum("im,im->m", normals, arms)
    level = ~(fall * fall > GRAZING_SINE**2 * np.einsum("im,im->m", arms, arms))
    return np.asarray(arms / np.where(level, np.nan, fall))


def symmetric_factor(covariance: FloatArray) -> FloatArray:
    """L with L L' = Q (k, k): Cholesky's; by eigenvalues where an element is fixed or rounding made one negative."""
    try:
        return np.asarray(np.linalg.cholesky(covariance))
    except np.linalg.LinAlgError:
        pass
    scale = np.sqrt(np.maximum(covariance.diagonal(), 0.0))
    safe = scale + (scale == 0.0)
    values, axes = np.linalg.eigh(covariance / (safe[:, None] * safe))
    return np.asarray(scale[:, None] * axes * np.sqrt(np.maximum(values, 0.0)))


def pair_covariance(factor: FloatArray, i: NDArray[np.intp], j: NDArray[np.intp]) -> FloatArray:
    """K_ij = F_i F_j' (m, 3, 3) of the pairs (i, j) (m,) of points."""
    return np.asarray(factor[i] @ factor[j].transpose(0, 2, 1))


def error_ellipses(covariances: FloatArray) -> FloatArray:
    """a^2, b^2 = (q11 + q22)/2 +- sqrt(((q11 - q22)/2)^2 + q12^2), azimuth = atan2(2 q12, q11 - q22) / 2 in [0, pi).

    `covariances` (n, 2, 2); (n, 3): semi-axes a >= b of the standard error ellipses, azimuth of a from the first axis
    towards the second. A circle and a point have azimuth 0; rounding below zero counts as b = 0; NaN stays NaN.
    """
    q11, q12, q22 = covariances[:, 0, 0], covariances[:, 0, 1], covariances[:, 1, 1]
    mean, radius = 0.5 * (q11 + q22), np.hypot(0.5 * (q11 - q22), q12)
    azimuth = 0.5 * np.arctan2(2 * q12, q11 - q22) % math.pi
    a, b = np.sqrt(np.maximum(mean + radius, 0.0)), np.sqrt(np.maximum(mean - radius, 0.0))
    is_turned = (radius > 0) & (azimuth < math.pi)  # a rounding below zero is pi by %
    return np.column_stack([a, b, np.where(is_turned, azimuth, 0.0 * radius)])
