"""s_i^2 + s_j^2 - 2 s_i s_j (f_i . f_j) = |P_i - P_j|^2: the exact resections of three points."""

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

LINE = 1e-9
SINGULAR, NEARLY_SINGULAR = 1e-12, 1e-4
"""Singular values that count as none; determinants from which cofactors keep enough digits."""
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
    return resections_of_triples(rays[None], ground[None])[0]


def resections_of_triples(rays: FloatArray, ground: FloatArray) -> list[list[tuple[FloatArray, FloatArray]]]:
    """`three_point_resections` of many triples (t, 3, 3) together, which costs little more than one."""
    clear = np.flatnonzero(~(_is_line(rays[..., :2] / rays[..., 2:]) | _is_line(ground)))
    i, j = PAIRS.T
    squares = np.sum((ground[:, i] - ground[:, j]) ** 2, axis=2)
    # 1 - cos from the chord keeps its digits in narrow fields
    versines = 0.5 * np.sum((rays[:, i] - rays[:, j]) ** 2, axis=2)
    starts, of = _approximate_distances(squares[clear], 1 - versines[clear])
    distances = _polished(starts, clear[of], squares, versines)
    at, kept = _distinct(distances, clear[of], squares, versines)
    R, S = _placed(kept[:, :, None] * rays[at], ground[at])
    found: list[list[tuple[FloatArray, FloatArray]]] = [[] for _ in rays]
    for k in np.flatnonzero(np.isfinite(S).all(axis=1)):
        found[at[k]].append((R[k], S[k]))
    return found


def _is_line(points: FloatArray) -> NDArray[np.bool_]:
    """Do three points (t, 3, d) lie on a line: second singular value below 1e-9 of the first? (t,)"""
    values = np.linalg.svd(points - points.mean(axis=1, keepdims=True), compute_uv=False)
    return np.asarray(values[:, 1] <= LINE * values[:, 0])


def _approximate_distances(squares: FloatArray, cosines: FloatArray) -> tuple[FloatArray, NDArray[np.intp]]:
    """Distances s (m, 3) from the real and nearly real roots v = s_3/s_1 of Grunert's quartics; their triples."""
    roots = _roots(_grunert_quartics(squares, cosines))
    usable = (np.abs(roots.imag) <= NEARLY_REAL * np.abs(roots)) & (roots.real > 0)
    t, _ = np.nonzero(usable)
    v = roots.real[usable]
    s1 = np.sqrt(squares[t, 1] / (1 + v * v - 2 * v * cosines[t, 1]))
    half_chord = np.sqrt(np.maximum(cosines[t, 2] ** 2 - 1 + squares[t, 2] / s1**2, 0.0))
    # both roots of the third equation: near u = cos(gamma) Grunert's own quotient for u is 0/0
    u = cosines[t, 2, None] + half_chord[:, None] * [1.0, -1.0]
    starts = np.stack([np.broadcast_to(s1[:, None], u.shape), u * s1[:, None], np.stack([v * s1] * 2, axis=1)], axis=2)
    return starts[u > 0], np.repeat(t, 2)[(u > 0).ravel()]


def _roots(coefficients: FloatArray) -> NDArray[np.complex128]:
    """Roots (t, 4) of quartics (t, 5), lowest power first; nan for those that an equation of lower degree lacks."""
    roots = np.full((len(coefficients), 4), np.nan, dtype=np.complex128)
    whole = coefficients[:, 4] != 0
    companion = np.zeros((int(whole.sum()), 4, 4))
    companion[:, np.arange(1, 4), np.arange(3)] = 1.0
    companion[:, :, 3] = -coefficients[whole, :4] / coefficients[whole, 4:]
    roots[whole] = np.sort(np.linalg.eigvals(companion[:, ::-1, ::-1]), axis=1)
    for t in np.flatnonzero(~whole):
        lower = polynomial.polyroots(polynomial.polytrim(coefficients[t]))
        roots[t, : len(lower)] = lower
    return roots


def _grunert_quartics(squares: FloatArray, cosines: FloatArray) -> FloatArray:
    """Coefficients (t, 5), lowest power first, of the polynomials in v = s_3/s_1."""
    a2, b2, c2 = squares.T
    ca, cb, cg = cosines.T
    d, e, k = (a2 - c2) / b2, (a2 + c2) / b2, c2 / b2
    return np.stack(
        [
            (1 + d) ** 2 - 4 * a2 / b2 * cg**2,
            4 * (-d * (1 + d) * cb + 2 * a2 / b2 * cg**2 * cb - (1 - e) * ca * cg),
            2 * (d**2 - 1 + 2 * d**2 * cb**2 + 2 * (b2 - c2) / b2 * ca**2 - 4 * e * ca * cb * cg)
            + 4 * (b2 - a2) / b2 * cg**2,
            4 * (d * (1 - d) * cb - (1 - e) * ca * cg + 2 * k * ca**2 * cb),
            (d - 1) ** 2 - 4 * k * ca**2,
        ],
        axis=1,
    )


def _polished(starts: FloatArray, of: NDArray[np.intp], squares: FloatArray, versines: FloatArray) -> FloatArray:
    """Newton steps on (s_i - s_j)^2 + 2 s_i s_j (1 - cos) = |P_i - P_j|^2 for all starts (m, 3) together.

    `of` (m,): the triple of each; the starts of one triple stop together.
    """
    s, (i, j) = starts.copy(), PAIRS.T
    going = np.arange(len(s))
    for _ in range(POLISH_STEPS):
        si, sj, versine = s[going][:, i], s[going][:, j], versines[of[going]]
        equations = _misclosures(s[going], squares[of[going]], versine)
        step = _solved(2 * (si - sj + sj * versine), 2 * (sj - si + si * versine), equations)
        s[going] -= step
        moved, size = np.zeros(len(squares)), np.zeros(len(squares))
        np.maximum.at(moved, of[going], np.abs(step).max(axis=1))
        np.maximum.at(size, of[going], np.abs(s[going]).max(axis=1))
        going = going[~(moved <= 1e-14 * size)[of[going]]]
        if not len(going):
            break
    return s


def _solved(by_i: FloatArray, by_j: FloatArray, y: FloatArray) -> FloatArray:
    """x (m, 3) with by_i x_i + by_j x_j = y (m, 3), an equation for each pair of PAIRS.

    By cofactors; least squares where two solutions meet and the equations are singular.
    """
    (a, c, e), (b, d, f), (y0, y1, y2) = by_i.T, by_j.T, y.T
    one, other = a * d * e, b * c * f
    determinant = one + other
    x = np.stack(
        [
            b * f * y1 + a * d * y2 - d * f * y0,
            d * e * y0 + b * c * y2 - b * e * y1,
            c * f * y0 + a * e * y1 - a * c * y2,
        ]
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        x = (x / determinant).T
    singular = np.flatnonzero(~(np.abs(determinant) > NEARLY_SINGULAR * (np.abs(one) + np.abs(other))))
    if len(singular):
        design = np.zeros((len(singular), 3, 3))
        rows, (i, j) = np.arange(3), PAIRS.T
        design[:, rows, i], design[:, rows, j] = by_i[singular], by_j[singular]
        x[singular] = (np.linalg.pinv(design, rcond=SINGULAR) @ y[singular, :, None])[:, :, 0]
    return np.asarray(x)


def _distinct(
    distances: FloatArray, of: NDArray[np.intp], squares: FloatArray, versines: FloatArray
) -> tuple[NDArray[np.intp], FloatArray]:
    """Triples and the four best of their positive distances (m, 3), without repetition; `of` (m,): their triples."""
    sound = np.isfinite(distances).all(axis=1) & np.all(distances > 0, axis=1)
    s, of = distances[sound], of[sound]
    errors = np.max(np.abs(_misclosures(s, squares[of], versines[of])), axis=1, initial=0.0)
    order = np.lexsort((errors, of))  # the best of a triple first
    kept: list[tuple[int, list[float]]] = []
    own: list[list[float]] = []
    for t, one in zip(of[order].tolist(), s[order].tolist(), strict=True):
        own = own if kept and kept[-1][0] == t else []
        same = SAME_SOLUTION * max(one)
        is_new = all(max(abs(a - b) for a, b in zip(one, other, strict=True)) > same for other in own)
        if is_new and len(own) < MOST_SOLUTIONS:
            own.append(one)
            kept.append((t, one))
    at = np.array([t for t, _ in kept], dtype=np.intp)
    return at, np.array([one for _, one in kept]).reshape(-1, 3)


def _misclosures(s: FloatArray, squares: FloatArray, versines: FloatArray) -> FloatArray:
    si, sj = s[:, PAIRS[:, 0]], s[:, PAIRS[:, 1]]
    return np.asarray((si - sj) ** 2 + 2 * si * sj * versines - squares)


def _placed(camera: FloatArray, ground: FloatArray) -> tuple[FloatArray, FloatArray]:
    """R (m, 3, 3), S (m, 3) that put camera triangles (m, 3, 3) on ground triangles (m, 3, 3): P = S + R p."""
    R = _triads(ground) @ _triads(camera).transpose(0, 2, 1)
    return R, ground.mean(axis=1) - (R @ camera.mean(axis=1)[:, :, None])[:, :, 0]


def _triads(points: FloatArray) -> FloatArray:
    """Right-handed orthonormal axes (columns) of triangles (..., 3, 3)."""
    first = _unit(points[..., 1, :] - points[..., 0, :])
    normal = _unit(np.cross(first, points[..., 2, :] - points[..., 0, :]))
    return np.stack([first, np.cross(normal, first), normal], axis=-1)


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))
