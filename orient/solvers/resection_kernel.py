"""Gauss-Newton of `resection_batch` by numba (extra `orient[fast]`): photo by photo, the points as columns."""

import math
from dataclasses import fields, replace

import numpy as np
from numba import njit

from orient.solvers.batch_iteration import BatchResection, Photos, unsolved
from orient.solvers.lean_resection import (
    LAST_IN_SIGMAS,
    LAST_STEP,
    MANY_POINTS,
    SINGULAR,
    SMALL_STEP,
    some_points,
)

# error_model: the default raises on division by zero, which forbids vector instructions
compiled = njit(cache=True, fastmath={"reassoc", "contract", "arcp", "nsz"}, error_model="numpy")


def by_kernel(photos: Photos, max_iterations: int) -> BatchResection:
    """As `resection_batch.by_numpy`; with many points from the orientations by some of them."""
    n = photos.image.shape[1]
    if n >= MANY_POINTS:
        at = some_points(n)
        image, ground = np.take(photos.image, at, axis=1), np.take(photos.ground, at, axis=1)
        few = by_kernel(replace(photos, image=image, ground=ground), max_iterations)
        photos = replace(photos, rotation=few.rotation, station=few.station)
    result = unsolved(photos)
    given = photos.image, photos.ground, photos.f, max_iterations
    _gauss_newton(*given, *(getattr(result, field.name) for field in fields(result)))
    return result


@compiled  # type: ignore[misc, unused-ignore]
def _gauss_newton(image, ground, f, max_iterations, R, S, Q, vPv, iterations, converged):  # type: ignore[no-untyped-def]
    """R, S are rough values at first; what converges is written."""
    n = image.shape[1]
    x, X = np.empty((2, n)), np.empty((3, n))
    M, N, L, g, step = np.empty((3, 4)), np.empty((6, 6)), np.empty((6, 6)), np.empty(6), np.empty(6)
    limit = LAST_IN_SIGMAS**2 / max(2 * n - 6, 1)
    for p in range(len(image)):
        origin = ground[p, 0]
        d = _columns(image[p], ground[p], f[p], S[p], x, X)
        _camera_from_ground(R[p], S[p], origin, d, M)
        for number in range(1, max_iterations + 1):
            e = _normal_equations(x, X, M, N, g)
            size = _solve(N, g, L, step)
            moved = _move(M, step)
            iterations[p] = number
            if not moved < np.inf:
                break
            if moved < LAST_STEP or (moved < SMALL_STEP and size < limit * e):
                converged[p] = _is_regular(N, L) and _in_front(X, M)
                break
        if converged[p]:
            _pose(M, origin, d, R[p], S[p])
            _cofactors(L, R[p], d, f[p], Q[p])
            vPv[p] = e * f[p] ** 2


@compiled  # type: ignore[misc, unused-ignore]
def _columns(image, ground, f, S, x, X):  # type: ignore[no-untyped-def]
    """x/f (2, n) and the ground (3, n) about its first point in camera distances; returns that distance."""
    gx, gy, gz = ground[0]
    d = math.sqrt((gx - S[0]) ** 2 + (gy - S[1]) ** 2 + (gz - S[2]) ** 2)
    a, b = 1.0 / f, 1.0 / d
    for i in range(len(image)):
        x[0, i], x[1, i] = image[i, 0] * a, image[i, 1] * a
        X[0, i], X[1, i], X[2, i] = (ground[i, 0] - gx) * b, (ground[i, 1] - gy) * b, (ground[i, 2] - gz) * b
    return d


@compiled  # type: ignore[misc, unused-ignore]
def _camera_from_ground(R, S, origin, d, M):  # type: ignore[no-untyped-def]
    for i in range(3):
        M[i, 3] = 0.0
        for k in range(3):
            M[i, k] = R[k, i]
            M[i, 3] += R[k, i] * (origin[k] - S[k]) / d


@compiled  # type: ignore[misc, unused-ignore]
def _normal_equations(x, X, M, N, g):  # type: ignore[no-untyped-def]
    """A'A (its lower triangle) and A'l of (r, t); returns l'l."""
    m00, m01, m02, m03 = M[0]
    m10, m11, m12, m13 = M[1]
    m20, m21, m22, m23 = M[2]
    a0 = a1 = a2 = a3 = a4 = a5 = a6 = a7 = a8 = a9 = a10 = a11 = a12 = a13 = a14 = a15 = a16 = 0.0
    g0 = g1 = g2 = g3 = g4 = g5 = e = 0.0
    for i in range(x.shape[1]):
        Xi, Yi, Zi = X[0, i], X[1, i], X[2, i]
        w = 1.0 / (m20 * Xi + m21 * Yi + m22 * Zi + m23)
        u = (m00 * Xi + m01 * Yi + m02 * Zi + m03) * w
        v = (m10 * Xi + m11 * Yi + m12 * Zi + m13) * w
        ex, ey = x[0, i] + u, x[1, i] + v
        uv, s, pu, pv = u * v, u * u + v * v, 1.0 + u * u, 1.0 + v * v
        wu, wv, ww = w * u, w * v, w * w
        a0 += uv * uv + pv * pv
        a1 += uv * (2.0 + s)
        a2 += u
        a3 += pu * pu + uv * uv
        a4 += v
        a5 += s
        a6 += w * uv
        a7 += w * pv
        a8 += wv * (1.0 + s)
        a9 += w * pu
        a10 += wu * (1.0 + s)
        a11 += wv
        a12 += wu
        a13 += ww
        a14 += ww * u
        a15 += ww * v
        a16 += ww * s
        g0 += uv * ex + pv * ey
        g1 += pu * ex + uv * ey
        g2 += v * ex - u * ey
        g3 += w * ex
        g4 += w * ey
        g5 += wu * ex + wv * ey
        e += ex * ex + ey * ey
    N[0, 0], N[1, 0], N[1, 1], N[2, 0], N[2, 1], N[2, 2] = a0, -a1, a3, -a2, -a4, a5
    N[3, 0], N[3, 1], N[3, 2], N[3, 3] = -a6, a9, -a11, a13
    N[4, 0], N[4, 1], N[4, 2], N[4, 3], N[4, 4] = -a7, a6, a12, 0.0, a13
    N[5, 0], N[5, 1], N[5, 2], N[5, 3], N[5, 4], N[5, 5] = a8, -a10, 0.0, -a14, -a15, a16
    g[0], g[1], g[2], g[3], g[4], g[5] = g0, -g1, g2, -g3, -g4, g5
    return e


@compiled  # type: ignore[misc, unused-ignore]
def _solve(N, g, L, step):  # type: ignore[no-untyped-def]
    """L L' = N, step = N^-1 g; returns g' N^-1 g. The diagonal of L is kept as its reciprocal."""
    size = 0.0
    for i in range(6):
        step[i] = g[i]
        for j in range(6):
            L[i, j] = N[i, j]
    for j in range(6):  # column by column, without sums in scalars: that becomes vector instructions
        L[j, j] = 1.0 / math.sqrt(L[j, j])
        step[j] *= L[j, j]
        size += step[j] ** 2
        for i in range(j + 1, 6):
            L[i, j] *= L[j, j]
            step[i] -= L[i, j] * step[j]
            for k in range(j + 1, i + 1):
                L[i, k] -= L[i, j] * L[k, j]
    for i in range(5, -1, -1):
        total = step[i]
        for k in range(i + 1, 6):
            total -= L[k, i] * step[k]
        step[i] = total * L[i, i]
    return size


@compiled  # type: ignore[misc, unused-ignore]
def _is_regular(N, L):  # type: ignore[no-untyped-def]
    """The diagonal of L is kept as its reciprocal."""
    is_regular = True
    for i in range(6):
        is_regular = is_regular and SINGULAR * N[i, i] * L[i, i] ** 2 < 1.0
    return is_regular


@compiled  # type: ignore[misc, unused-ignore]
def _move(M, step):  # type: ignore[no-untyped-def]
    """P_camera <- E P_camera + t, E = I + 2 ([c]x + [c]x^2) / (1 + c'c), c = r/2; returns the sum of |r| and |t|."""
    x, y, z = 0.5 * step[0], 0.5 * step[1], 0.5 * step[2]
    a = 2.0 / (1.0 + x * x + y * y + z * z)
    for k in range(4):
        X, Y, Z = M[0, k], M[1, k], M[2, k]
        cx, cy, cz = y * Z - z * Y, z * X - x * Z, x * Y - y * X
        M[0, k] += a * (cx + y * cz - z * cy)
        M[1, k] += a * (cy + z * cx - x * cz)
        M[2, k] += a * (cz + x * cy - y * cx)
    total = 0.0
    for i in range(3):
        M[i, 3] += step[3 + i]
        total += abs(step[i]) + abs(step[3 + i])
    return total


@compiled  # type: ignore[misc, unused-ignore]
def _in_front(X, M):  # type: ignore[no-untyped-def]
    a, b, c, d = M[2]
    behind = 0
    for i in range(X.shape[1]):
        behind += a * X[0, i] + b * X[1, i] + c * X[2, i] + d >= 0.0
    return behind == 0


@compiled  # type: ignore[misc, unused-ignore]
def _pose(M, origin, d, R, S):  # type: ignore[no-untyped-def]
    for k in range(3):
        S[k] = origin[k]
        for i in range(3):
            R[k, i] = M[i, k]
            S[k] -= d * M[i, k] * M[i, 3]


@compiled  # type: ignore[misc, unused-ignore]
def _cofactors(L, R, d, f, Q):  # type: ignore[no-untyped-def]
    """Of (r, S) in the ground's axes: F F', L F' = (R, R d)' / f by forward substitution."""
    F = np.empty((6, 6))
    for j in range(6):
        for i in range(6):
            total = 0.0
            if i < 3 and j < 3:
                total = R[j, i] / f
            elif i >= 3 and j >= 3:
                total = R[j - 3, i - 3] * d / f
            for k in range(i):
                total -= L[i, k] * F[j, k]
            F[j, i] = total * L[i, i]
    for i in range(6):
        for j in range(i + 1):
            total = 0.0
            for k in range(6):
                total += F[i, k] * F[j, k]
            Q[i, j] = total
            Q[j, i] = total
