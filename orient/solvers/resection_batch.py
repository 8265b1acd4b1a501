"""R, S and Q (6 x 6) of many photos at once: (A'A) d = A' l in the camera's own axes, by sums over the points.

With u = xs/zs, v = ys/zs, w = d/zs (d: mean distance) a point moved by a turn r and a shift t d of the ground in the
camera's axes moves its image by

    dx/f = u v r1 - (1 + u^2) r2 + v r3 - w t1 + u w t3
    dy/f = (1 + v^2) r1 - u v r2 - u r3 - w t2 + v w t3

so that A'A and A'l are 24 sums of products of u, v, w and the misclosures: no design matrix is ever written.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.geometry.rotation import cross_matrix
from orient.solvers.lean_resection import LeanResection, lean_resection
from orient.solvers.start_values import start_candidates

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
Sums = Callable[[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray], FloatArray]

POINTS_AT_ONCE = 6144
"""Points whose products stay in the processor's cache."""
FEW_PHOTOS = 4
PHOTOS_AT_ONCE = 4096
"""Photos of a block when the kernel is compiled and holds no products."""
COMPILED_FROM = 100_000
"""Points of all photos together from which a compiled kernel is worth its loading."""
LAST_STEP = 1e-4
"""In standard deviations, of which the square is left: the iteration of a photo ends with a smaller step."""
STARTS_TRIED = 6
MISFIT = 0.01
CROSS = np.array([cross_matrix(axis).ravel() for axis in np.eye(3)])
"""[r]x = r CROSS, row by row."""
N_SUMS = 25


@dataclass(frozen=True, slots=True)
class BatchResection:
    """Orientations of p photos: R (p, 3, 3), S (p, 3), cofactors Q (p, 6, 6) of (r, S) with R_new = exp([r]x) R.

    `vPv` (p,) [mm^2]; `iterations` (p,); `converged` (p,): False where no start led to an end with all points in
    front: such a photo has NaN, and `resect` says why.
    """

    rotation: FloatArray
    station: FloatArray
    Q: FloatArray
    vPv: FloatArray
    iterations: NDArray[np.int64]
    converged: BoolArray


def resection_batch(
    image: FloatArray,
    ground: FloatArray,
    f_mm: FloatArray | float,
    rotation: FloatArray | None = None,
    station: FloatArray | None = None,
    *,
    max_iterations: int = 20,
    compiled: bool | None = None,
) -> BatchResection:
    """x = -f xs/zs, y = -f ys/zs, (xs, ys, zs) = R'(P - S), v'v -> min for each of p photos of n points.

    `image` (p, n, 2) [mm], refined; `ground` (p, n, 3) [m], right-handed, without errors; `f_mm` one or (p,).
    `rotation` (p, 3, 3), `station` (p, 3): rough values; without them each photo begins as a vertical one. Where a
    start leads nowhere, or a vertical one to a bad fit, those of `start_candidates` are tried. One photo with very
    many points is a batch too. Covariance = v'v/(2n - 6) Q.
    `compiled`: sums by numba (extra `orient[fast]`), by default where it is installed and there are enough points;
    the results agree to 1e-9. Source: seed 004, equations (3)-(5) with fixed control.
    """
    f = np.broadcast_to(np.asarray(f_mm, dtype=np.float64), (len(image),))
    sums = _sums_by(compiled, image.shape[0] * image.shape[1])
    is_rough = rotation is None or station is None
    start = _vertical(image, ground, f) if rotation is None or station is None else (rotation, station)
    result = _by_blocks(image, ground, f, *start, max_iterations, sums)
    doubtful = ~result.converged | (_misfits(result, image) if is_rough else False)
    for place in np.flatnonzero(doubtful).tolist():
        at = slice(place, place + 1)
        _retry(result, at, image[at], ground[at], f[at], max_iterations, sums)
    return result


def _empty(p: int) -> BatchResection:
    def nothing(*shape: int) -> FloatArray:
        return np.full((p, *shape), np.nan)

    counts = np.zeros(p, dtype=np.int64)
    return BatchResection(nothing(3, 3), nothing(3), nothing(6, 6), nothing(), counts, counts > 0)


def _vertical(image: FloatArray, ground: FloatArray, f: FloatArray) -> tuple[FloatArray, FloatArray]:
    """R, S of vertical photos: the similarity of image and plan, x + i y = a (X + i Y - X_S - i Y_S), H = f / |a|."""
    q, g = image[:, :, 0] + 1j * image[:, :, 1], ground[:, :, 0] + 1j * ground[:, :, 1]
    q_mean, g_mean = q.mean(axis=1), g.mean(axis=1)
    about = g - g_mean[:, None]
    with np.errstate(all="ignore"):
        a = np.sum(about.conj() * (q - q_mean[:, None]), axis=1) / np.sum(np.abs(about) ** 2, axis=1)
        plan, scale = g_mean - q_mean / a, np.abs(a)
    c, s = a.real / scale, -a.imag / scale
    zero, one = np.zeros_like(c), np.ones_like(c)
    R = np.stack([np.stack([c, s, zero]), np.stack([-s, c, zero]), np.stack([zero, zero, one])]).transpose(2, 1, 0)
    return R, np.stack([plan.real, plan.imag, ground[:, :, 2].mean(axis=1) + f / scale], axis=1)


def _misfits(result: BatchResection, image: FloatArray) -> BoolArray:
    """Photos whose residuals are more than a hundredth of the spread of their image points: another end may fit."""
    spread = np.sum(np.square(image - image.mean(axis=1, keepdims=True)), axis=(1, 2))
    return np.asarray(~(result.vPv < MISFIT**2 * spread))


def _retry(
    result: BatchResection,
    at: slice,
    image: FloatArray,
    ground: FloatArray,
    f: FloatArray,
    max_iterations: int,
    sums: Sums,
) -> None:
    """Fill one photo of the result with the best end of its own starts."""
    candidates = start_candidates(image[0], ground[0], float(f[0]))[:STARTS_TRIED]
    ends = [
        _block(image, ground, f, start.rotation[None], start.station[None], max_iterations, sums)
        for start in candidates
    ]
    valid = [end for end in ends if end.converged[0]]
    if valid:
        _put(result, at, min(valid, key=lambda end: float(end.vPv[0])))


def _put(result: BatchResection, at: slice, part: BatchResection) -> None:
    for name in BatchResection.__slots__:
        getattr(result, name)[at] = getattr(part, name)


def _by_blocks(
    image: FloatArray,
    ground: FloatArray,
    f: FloatArray,
    rotation: FloatArray,
    station: FloatArray,
    max_iterations: int,
    sums: Sums,
) -> BatchResection:
    result = _empty(len(image))
    if len(image) <= FEW_PHOTOS and sums is photo_sums:
        for p in range(len(image)):
            lean = lean_resection(image[p], ground[p], float(f[p]), rotation[p], station[p], None, max_iterations)
            _put(result, slice(p, p + 1), _as_batch(lean))
        return result
    photos = max(POINTS_AT_ONCE // image.shape[1], 1) if sums is photo_sums else PHOTOS_AT_ONCE
    for begin in range(0, len(image), photos):
        at = slice(begin, begin + photos)
        _put(result, at, _block(image[at], ground[at], f[at], rotation[at], station[at], max_iterations, sums))
    return result


def _as_batch(lean: LeanResection) -> BatchResection:
    numbers, converged = np.array([lean.iterations]), np.array([lean.converged])
    return BatchResection(
        lean.rotation[None], lean.station[None], lean.Q[None], np.array([lean.vPv]), numbers, converged
    )


def _block(
    image: FloatArray,
    ground: FloatArray,
    f: FloatArray,
    rotation: FloatArray,
    station: FloatArray,
    max_iterations: int,
    sums: Sums,
) -> BatchResection:
    """Gauss-Newton for all photos of a block together, until each has made its last step."""
    origin = ground.mean(axis=1)
    scaled = image / f[:, None, None]
    relative = ground - origin[:, None, :]
    R, S = rotation.copy(), station - origin
    count = np.zeros(len(image), dtype=np.int64)
    running = np.ones(len(image), dtype=np.bool_)
    finite = running.copy()
    redundancy = max(2 * image.shape[1] - 6, 1)
    with np.errstate(all="ignore"):
        for number in range(1, max_iterations + 1):
            distance = np.linalg.norm(S, axis=1)
            found = sums(scaled, relative, R, S, distance)
            L = _cholesky(_normal_matrix(found))
            y = _forward(L, _right_sides(found))
            step = _backward(L, y)
            running &= finite
            _apply(R, S, step, distance, running)
            count[running] = number
            size = np.sum(np.square(y), axis=0) * redundancy / found[24]
            finite &= np.isfinite(size)
            running &= ~(size < LAST_STEP**2)
            if not (running & finite).any():
                break
        Q = _in_ground(_inverse(L), R, distance) / np.square(f)[:, None, None]
        in_front = np.all(np.einsum("pni,pi->pn", relative - S[:, None], R[:, :, 2]) < 0, axis=1)
    converged = finite & ~running & in_front
    Q[~converged] = np.nan
    return BatchResection(R, S + origin, Q, found[24] * np.square(f), count, converged)


def _apply(R: FloatArray, S: FloatArray, step: FloatArray, distance: FloatArray, running: BoolArray) -> None:
    """P_camera <- exp([r]x) P_camera + t d: R <- R E', S <- S - (E R')' t d."""
    at = slice(None) if running.all() else running
    r, t = step[:3].T[at], step[3:].T[at] * distance[at, None]
    turned = R[at] @ _turns(r).transpose(0, 2, 1)
    R[at] = turned
    S[at] -= (turned @ t[:, :, None])[:, :, 0]


def _turns(r: FloatArray) -> FloatArray:
    """exp([r]x) = cos t I + sin(t)/t [r]x + (1 - cos t)/t^2 r r', t = |r|, of rotation vectors (p, 3): (p, 3, 3)."""
    t = np.linalg.norm(r, axis=1)
    b = 0.5 * np.sinc(t / (2 * np.pi)) ** 2
    K = (np.sinc(t / np.pi)[:, None] * r @ CROSS).reshape(-1, 3, 3)
    return np.asarray(K + b[:, None, None] * r[:, :, None] * r[:, None, :] + np.cos(t)[:, None, None] * np.eye(3))


def _in_ground(inverse: FloatArray, R: FloatArray, distance: FloatArray) -> FloatArray:
    """Cofactors of (r, S) in the ground's axes from those of (r, t) in the camera's: r -> -R r, dS = -R t d."""
    turn = np.zeros((len(R), 6, 6))
    turn[:, :3, :3] = R
    turn[:, 3:, 3:] = R * distance[:, None, None]
    return np.asarray(turn @ inverse @ turn.transpose(0, 2, 1))


def _sums_by(compiled: bool | None, points: int) -> Sums:
    """The compiled sums where they are asked for, or are there and worth while."""
    if compiled is False or (compiled is None and points < COMPILED_FROM):
        return photo_sums
    try:
        from orient.solvers.resection_kernel import compiled_sums
    except ImportError:
        if compiled:
            raise
        return photo_sums
    return compiled_sums


def photo_sums(
    image: FloatArray, ground: FloatArray, rotation: FloatArray, station: FloatArray, distance: FloatArray
) -> FloatArray:
    """The 25 sums (25, p) of `_normal_matrix` and `_right_sides`, and v'v/f^2: `image` x/f (p, n, 2)."""
    total = np.zeros((N_SUMS, len(image)))
    for begin in range(0, image.shape[1], POINTS_AT_ONCE):
        part = slice(begin, begin + POINTS_AT_ONCE)
        total += _part_sums(image[:, part], ground[:, part], rotation, station, distance)
    return total


def _part_sums(
    image: FloatArray, ground: FloatArray, rotation: FloatArray, station: FloatArray, distance: FloatArray
) -> FloatArray:
    xs, ys, zs = np.moveaxis((ground - station[:, None]) @ rotation, 2, 0)
    inverse = 1.0 / zs
    u, v, w = xs * inverse, ys * inverse, distance[:, None] * inverse
    ex, ey = image[:, :, 0] + u, image[:, :, 1] + v
    uu, vv, uv, ww = u * u, v * v, u * v, w * w
    s = uu + vv
    pu, pv = 1.0 + uu, 1.0 + vv
    wu, wv = w * u, w * v
    products = (
        uv * uv + pv * pv, uv * (2.0 + s), u, pu * pu + uv * uv, v, s,
        w * uv, w * pv, wv * (1.0 + s), w * pu, wu * (1.0 + s), wv, wu,
        ww, ww * u, ww * v, ww * s,
        uv * ex + pv * ey, pu * ex + uv * ey, v * ex - u * ey, w * ex, w * ey, wu * ex + wv * ey,
        np.ones_like(u), ex * ex + ey * ey,
    )  # fmt: skip
    return np.array(products) @ np.ones(image.shape[1])


def _normal_matrix(m: FloatArray) -> FloatArray:
    """A'A (6, 6, p), its lower triangle, of (r1, r2, r3, t1, t2, t3)."""
    N = np.zeros((6, 6, m.shape[1]))
    N[0, 0], N[1, 0], N[2, 0] = m[0], -m[1], -m[2]
    N[1, 1], N[2, 1], N[2, 2] = m[3], -m[4], m[5]
    N[3, 0], N[4, 0], N[5, 0] = -m[6], -m[7], m[8]
    N[3, 1], N[4, 1], N[5, 1] = m[9], m[6], -m[10]
    N[3, 2], N[4, 2] = -m[11], m[12]
    N[3, 3], N[5, 3], N[4, 4], N[5, 4], N[5, 5] = m[13], -m[14], m[13], -m[15], m[16]
    return N


def _right_sides(m: FloatArray) -> FloatArray:
    """A'l (6, p)."""
    return np.stack([m[17], -m[18], m[19], -m[20], -m[21], m[22]])


def _cholesky(N: FloatArray) -> FloatArray:
    """L (6, 6, p) with L L' = N, for all photos at once."""
    L = np.zeros_like(N)
    for j in range(len(N)):
        column = N[j:, j] - np.sum(L[j:, :j] * L[j, :j], axis=1)
        L[j:, j] = column / np.sqrt(column[0])
    return L


def _forward(L: FloatArray, b: FloatArray) -> FloatArray:
    """L^-1 b."""
    x = np.empty_like(b)
    for i in range(len(b)):
        x[i] = (b[i] - np.sum(L[i, :i] * x[:i], axis=0)) / L[i, i]
    return x


def _backward(L: FloatArray, y: FloatArray) -> FloatArray:
    """L'^-1 y."""
    x = np.empty_like(y)
    for i in range(len(y) - 1, -1, -1):
        x[i] = (y[i] - np.sum(L[i + 1 :, i] * x[i + 1 :], axis=0)) / L[i, i]
    return x


def _inverse(L: FloatArray) -> FloatArray:
    """(L L')^-1 (p, 6, 6)."""
    lower = np.zeros_like(L)
    for i in range(len(L)):
        lower[i, i] = 1.0 / L[i, i]
        for j in range(i):
            lower[i, j] = -np.sum(L[i, j:i] * lower[j:i, j], axis=0) / L[i, i]
    F = np.moveaxis(lower, 2, 0)
    return np.asarray(F.transpose(0, 2, 1) @ F)
