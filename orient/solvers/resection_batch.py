"""R, S and Q (6 x 6) of many photos at once, by numpy for all photos of a block together or compiled."""

from collections.abc import Callable
from dataclasses import fields, replace

import numpy as np
from numpy.typing import NDArray

from orient.solvers.batch_iteration import BatchResection, Photos, gauss_newton, unsolved
from orient.solvers.start_values import start_candidates

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
BoolArray = NDArray[np.bool_]
Solver = Callable[[Photos, int], BatchResection]

POINTS_AT_ONCE = 12_288
"""Points whose equations stay in the processor's cache."""
FEW_PHOTOS, MANY_POINTS = 4, 1000
"""So few photos, or photos with so many points, are solved one by one."""
FEW_LEFT = 0.1
"""The slowest photos of all blocks go together, from the beginning."""
COMPILED_FROM = 100_000
"""Points of all photos together from which a compiled kernel is worth its loading."""
STARTS_TRIED = 6
MISFIT = 0.01


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
    `compiled`: by numba (extra `orient[fast]`), by default where it is installed and there are enough points;
    of photos that fit, the results agree to 1e-9. Source: seed 004, equations (3)-(5) with fixed control.
    """
    f = np.broadcast_to(np.asarray(f_mm, dtype=np.float64), (len(image),))
    is_rough = rotation is None or station is None
    start = _vertical(image, ground, f) if rotation is None or station is None else (rotation, station)
    photos = Photos(image, ground, f, *start)
    solve = _solver(compiled, image.shape[0] * image.shape[1])
    result = solve(photos, max_iterations)
    doubtful = ~result.converged | (_misfits(result, image) if is_rough else False)
    for place in np.flatnonzero(doubtful).tolist():
        at = slice(place, place + 1)
        _retry(result, at, photos[at], solve, max_iterations)
    return result


def _vertical(image: FloatArray, ground: FloatArray, f: FloatArray) -> tuple[FloatArray, FloatArray]:
    """R, S of vertical photos: the similarity of image and plan, x + i y = a (X + i Y - X_S - i Y_S), H = f / |a|."""
    (q, q_mean), (g, g_mean) = _about_mean(image), _about_mean(ground)
    with np.errstate(all="ignore"):
        a = np.vecdot(g, q) / np.vecdot(g, g).real
        scale = np.abs(a)
        turn, plan, height = a / scale, g_mean - q_mean / a, f / scale
    R, S = np.zeros((len(image), 3, 3)), np.empty((len(image), 3))
    R[:, 0, 0] = R[:, 1, 1] = turn.real
    R[:, 0, 1], R[:, 1, 0] = turn.imag, -turn.imag
    R[:, 2, 2] = 1.0
    S[:, 0], S[:, 1] = plan.real, plan.imag
    S[:, 2] = np.add.reduce(ground[:, :, 2], axis=1) / ground.shape[1] + height
    return R, S


def _about_mean(points: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """x + i y (p, n) of points (p, n, 2 or 3) about their mean (p,)."""
    z = points[:, :, 0] + 1j * points[:, :, 1]
    mean = np.add.reduce(z, axis=1) / z.shape[1]
    return z - mean[:, None], mean


def _misfits(result: BatchResection, image: FloatArray) -> BoolArray:
    """Photos whose residuals are more than a hundredth of the spread of their image points: another end may fit."""
    spread = np.square(np.abs(_about_mean(image)[0]))
    return np.asarray(~(result.vPv < MISFIT**2 * np.add.reduce(spread, axis=1)))


def _retry(result: BatchResection, at: slice, photo: Photos, solve: Solver, max_iterations: int) -> None:
    """Fill one photo of the result with the best end of its own starts."""
    try:
        with np.errstate(all="ignore"):
            candidates = start_candidates(photo.image[0], photo.ground[0], float(photo.f[0]))[:STARTS_TRIED]
    except np.linalg.LinAlgError:  # all points in one place
        return
    starts = [replace(photo, rotation=one.rotation[None], station=one.station[None]) for one in candidates]
    valid = [end for end in (solve(start, max_iterations) for start in starts) if end.converged[0]]
    if valid:
        result.put(at, min(valid, key=lambda end: float(end.vPv[0])))


def _solver(compiled: bool | None, points: int) -> Solver:
    """The compiled one where it is asked for, or is there and worth while."""
    if compiled is False or (compiled is None and points < COMPILED_FROM):
        return by_numpy
    try:
        from orient.solvers.resection_kernel import by_kernel
    except ImportError:
        if compiled:
            raise
        return by_numpy
    return by_kernel


def by_numpy(photos: Photos, max_iterations: int) -> BatchResection:
    """Few photos or many points one by one, otherwise in blocks."""
    p, n, _ = photos.image.shape
    if p <= FEW_PHOTOS or n >= MANY_POINTS:
        return _one_by_one(photos, max_iterations)
    result = unsolved(photos)
    _solve_blocks(result, photos, np.arange(p), max_iterations, FEW_LEFT)
    _solve_blocks(result, photos, np.flatnonzero(result.iterations == 0), max_iterations, 0.0)
    return result


def _solve_blocks(
    result: BatchResection, photos: Photos, which: NDArray[np.intp], max_iterations: int, may_be_left: float
) -> None:
    together = POINTS_AT_ONCE // photos.image.shape[1]
    for begin in range(0, len(which), together):
        at = which[begin : begin + together]
        result.put(at, gauss_newton(photos[at], max_iterations, may_be_left))


def _one_by_one(photos: Photos, max_iterations: int) -> BatchResection:
    from orient.solvers.lean_resection import lean_resection  # and SciPy's LAPACK, which loads slowly

    result = unsolved(photos)
    given = zip(photos.image, photos.ground, photos.f.tolist(), photos.rotation, photos.station, strict=True)
    for at, photo in enumerate(given):
        one = lean_resection(*photo, max_iterations=max_iterations, may_be_far=False)
        for field in fields(result):
            getattr(result, field.name)[at] = getattr(one, field.name)
    return result
