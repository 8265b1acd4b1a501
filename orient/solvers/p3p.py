"""s_i^2 + s_j^2 - 2 s_i s_j (f_i . f_j) = |P_i - P_j|^2: the exact resections of three points."""

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

LINE = 1e-9
NEARLY_REAL = 0.1
SAME_SOLUTION = 1e-6
POLISH_STEPS = 8
MOST_SOLUTIONS = 4
PAIRS = np.array([[1, 2], [0, 2], [0, 1]])


def three_point_resections(rays: FloatArray, ground: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    """P_i = S + s_i R f_i, i = 1..3: every (R, S) that sees three ground points along three camera rays.

    `rays` (3, 3): unit vectors f_i = (x, y, -f) / |.| in the camera, one per row; `ground` (3, 3) [m], right-handed.
    Returns up to four pairs (R ground_from_image, S), all with s_i > 0. Where noise has removed a double solution
    (camera near the vertical cylinder through the points) its nearest approach stands in. Points on a line, in the
    image or on the ground, give an empty list.
    Source: Grunert (1841), quartic as in Haralick, Lee, Ottenberg, Noelle (1994), equations (8)-(9); the distances
    are then improved by Newton steps on the three equations.
    """
    if _is_line(rays[:, :2] / rays[:, 2:]) or _is_line(ground):
        return []
    squares = np.array([np.sum((ground[i] - ground[j]) ** 2) for i, j in PAIRS])
    # 1 - cos from the chord keeps its digits in narrow fields
    versines = np.array([0.5 * np.sum((rays[i] - rays[j]) ** 2) for i, j in PAIRS])
    distances = _polished(_approximate_distances(squares, 1 - versines), squares, versines)
    R, S = _placed(_distinct(distances, squares, versines)[:, :, None] * rays, ground)
    return [(R[k], S[k]) for k in range(len(S)) if np.isfinite(S[k]).all()]


def _is_line(points: FloatArray) -> bool:
    """Do three points lie on a line: second singular value below 1e-9 of the first?"""
    values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(values[1] <= LINE * values[0])


def _approximate_distances(squares: FloatArray, cosines: FloatArray) -> FloatArray:
    """Distances s (m, 3) from the real and nearly real roots v = s_3/s_1 of Grunert's quartic."""
    roots = polynomial.polyroots(polynomial.polytrim(_grunert_quartic(squares, cosines)))
    ratios = roots.real[(np.abs(roots.imag) <= NEARLY_REAL * np.abs(roots)) & (roots.real > 0)]
    starts = []
    for v in ratios:
        s1 = np.sqrt(squares[1] / (1 + v * v - 2 * v * cosines[1]))
        half_chord = np.sqrt(max(cosines[2] ** 2 - 1 + squares[2] / s1**2, 0.0))
        # both roots of the third equation: near u = cos(gamma) Grunert's own quotient for u is 0/0
        starts += [np.array([s1, u * s1, v * s1]) for u in (cosines[2] + half_chord, cosines[2] - half_chord) if u > 0]
    return np.array(starts).reshape(-1, 3)


def _grunert_quartic(squares: FloatArray, cosines: FloatArray) -> FloatArray:
    """Coefficients (5,), lowest power first, of the polynomial in v = s_3/s_1."""
    a2, b2, c2 = squares
    ca, cb, cg = cosines
    d, e, k = (a2 - c2) / b2, (a2 + c2) / b2, c2 / b2
    return np.array(
        [
            (1 + d) ** 2 - 4 * a2 / b2 * cg**2,
            4 * (-d * (1 + d) * cb + 2 * a2 / b2 * cg**2 * cb - (1 - e) * ca * cg),
            2 * (d**2 - 1 + 2 * d**2 * cb**2 + 2 * (b2 - c2) / b2 * ca**2 - 4 * e * ca * cb * cg)
            + 4 * (b2 - a2) / b2 * cg**2,
            4 * (d * (1 - d) * cb - (1 - e) * ca * cg + 2 * k * ca**2 * cb),
            (d - 1) ** 2 - 4 * k * ca**2,
        ]
    )


def _polished(starts: FloatArray, squares: FloatArray, versines: FloatArray) -> FloatArray:
    """Newton steps on (s_i - s_j)^2 + 2 s_i s_j (1 - cos) = |P_i - P_j|^2 for all starts (m, 3) together."""
    s = starts
    rows, (i, j) = np.arange(3), PAIRS.T
    for _ in range(POLISH_STEPS):
        si, sj = s[:, i], s[:, j]
        equations = _misclosures(s, squares, versines)
        design = np.zeros((len(s), 3, 3))
        design[:, rows, i] = 2 * (si - sj + sj * versines)
        design[:, rows, j] = 2 * (sj - si + si * versines)
        # pseudo-inverse: least squares where two solutions meet and the equations are singular
        step = (np.linalg.pinv(design, rcond=1e-12) @ equations[:, :, None])[:, :, 0]
        s = s - step
        if np.max(np.abs(step), initial=0.0) <= 1e-14 * np.max(np.abs(s), initial=0.0):
            break
    return s


def _distinct(distances: FloatArray, squares: FloatArray, versines: FloatArray) -> FloatArray:
    """The four best of the positive distances (m, 3), without repetition."""
    sound = distances[np.isfinite(distances).all(axis=1) & np.all(distances > 0, axis=1)]
    errors = np.max(np.abs(_misclosures(sound, squares, versines)) / np.max(squares), axis=1, initial=0.0)
    kept: list[FloatArray] = []
    for s in sound[np.argsort(errors, kind="stable")]:
        if len(kept) < MOST_SOLUTIONS and all(np.max(np.abs(s - t)) > SAME_SOLUTION * np.max(s) for t in kept):
            kept.append(s)
    return np.array(kept).reshape(-1, 3)


def _misclosures(s: FloatArray, squares: FloatArray, versines: FloatArray) -> FloatArray:
    si, sj = s[:, PAIRS[:, 0]], s[:, PAIRS[:, 1]]
    return np.asarray((si - sj) ** 2 + 2 * si * sj * versines - squares)


def _placed(camera: FloatArray, ground: FloatArray) -> tuple[FloatArray, FloatArray]:
    """R (m, 3, 3), S (m, 3) that put camera triangles (m, 3, 3) on the ground triangle (3, 3): P = S + R p."""
    R = _triads(ground) @ _triads(camera).transpose(0, 2, 1)
    return R, ground.mean(axis=0) - (R @ camera.mean(axis=1)[:, :, None])[:, :, 0]


def _triads(points: FloatArray) -> FloatArray:
    """Right-handed orthonormal axes (columns) of triangles (..., 3, 3)."""
    first = _unit(points[..., 1, :] - points[..., 0, :])
    normal = _unit(np.cross(first, points[..., 2, :] - points[..., 0, :]))
    return np.stack([first, np.cross(normal, first), normal], axis=-1)


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))
