"""Gauss-Newton of `resection_batch` by numba (extra `orient[fast]`): sixteen photos at a time, one in each lane.

Lanes are the last axis of all arrays: a loop over them becomes vector instructions, where twelve points or six unknowns
of one photo are too few. A photo that has ended leaves its lane to the next one. Photos with many points go one by one:
their sums run over the points, and all lanes hold the same.
"""

import math
from dataclasses import fields, replace

import numpy as np

from orient.solvers.batch_iteration import BatchResection, Photos, unsolved
from orient.solvers.compiling import compiled, inlined
from orient.solvers.lean_limits import LAST_IN_SIGMAS, LAST_STEP, MANY_POINTS, SINGULAR, SMALL_STEP, some_points

LANES = 16
ENOUGH_POINTS = 400
"""Points of a photo that goes by itself."""


def by_kernel(photos: Photos, max_iterations: int) -> BatchResection:
    """As `resection_batch.by_numpy`; with many points from the orientations by some of them."""
    p, n, _ = photos.image.shape
    if n >= MANY_POINTS:
        at = some_points(n)
        image, ground = np.take(photos.image, at, axis=1), np.take(photos.ground, at, axis=1)
        few = by_kernel(replace(photos, image=image, ground=ground), max_iterations)
        photos = replace(photos, rotation=few.rotation, station=few.station)
    result = unsolved(photos)
    given = photos.image, photos.ground, photos.f, max_iterations
    solve = _photos_in_lanes if p >= LANES and n < ENOUGH_POINTS else _one_by_one
    solve(*given, *(getattr(result, field.name) for field in fields(result)))
    return result


@compiled  # type: ignore[misc, unused-ignore]
def _photos_in_lanes(image, ground, f, max_iterations, R, S, Q, vPv, iterations, converged):  # type: ignore[no-untyped-def]
    """R, S are rough values at first; what converges is written."""
    p, n = image.shape[:2]
    points, M, N = np.empty((n, 5, LANES)), np.empty((3, 4, LANES)), np.empty((7, 7, LANES))
    step, size, moved = np.empty((6, LANES)), np.empty(LANES), np.empty(LANES)
    photo, distance, F = np.empty(LANES, np.int64), np.empty(LANES), np.empty((6, 6))
    limit = LAST_IN_SIGMAS**2 / max(2 * n - 6, 1)
    for k in range(LANES):
        photo[k] = k
        distance[k] = _begin(R[k], S[k], ground[k, 0], M, k)
        _columns(image[k], ground[k], f[k], distance[k], points[:, :2, k].T, points[:, 2:, k].T)
    following = running = LANES
    while running > 0:
        _normal_equations(points, M, N)
        _factor(N)
        _solve(N, step, size)
        _move(M, step, moved)
        for k in range(LANES):
            q = photo[k]
            if q < 0:
                continue
            iterations[q] += 1
            has_ended = moved[k] < LAST_STEP or (moved[k] < SMALL_STEP and size[k] < limit * N[6, 6, k])
            if has_ended and _is_regular(N, k) and _in_front(points[:, 2:, k].T, M, k):
                converged[q] = True
                _pose(M, k, ground[q, 0], distance[k], R[q], S[q])
                _cofactors(N, k, R[q], distance[k], f[q], F, Q[q])
                vPv[q] = N[6, 6, k] * f[q] ** 2
            if not has_ended and moved[k] < np.inf and iterations[q] < max_iterations:
                continue
            if following < p:
                q = photo[k] = following
                following += 1
                distance[k] = _begin(R[q], S[q], ground[q, 0], M, k)
                _columns(image[q], ground[q], f[q], distance[k], points[:, :2, k].T, points[:, 2:, k].T)
            else:
                photo[k] = -1
                running -= 1


@compiled  # type: ignore[misc, unused-ignore]
def _one_by_one(image, ground, f, max_iterations, R, S, Q, vPv, iterations, converged):  # type: ignore[no-untyped-def]
    """The same photo by photo, each in all lanes."""
    p, n = image.shape[:2]
    x, X, M, N = np.empty((2, n)), np.empty((3, n)), np.empty((3, 4, LANES)), np.empty((7, 7, LANES))
    step, size, moved, F = np.empty((6, LANES)), np.empty(LANES), np.empty(LANES), np.empty((6, 6))
    limit = LAST_IN_SIGMAS**2 / max(2 * n - 6, 1)
    for q in range(p):
        origin, d = ground[q, 0], 0.0
        for k in range(LANES):
            d = _begin(R[q], S[q], origin, M, k)
        _columns(image[q], ground[q], f[q], d, x, X)
        for number in range(1, max_iterations + 1):
            iterations[q] = number
            _normal_equations_of_one(x, X, M, N)
            _factor(N)
            _solve(N, step, size)
            _move(M, step, moved)
            if not moved[0] < np.inf:
                break
            if moved[0] < LAST_STEP or (moved[0] < SMALL_STEP and size[0] < limit * N[6, 6, 0]):
                converged[q] = _is_regular(N, 0) and _in_front(X, M, 0)
                break
        if converged[q]:
            _pose(M, 0, origin, d, R[q], S[q])
            _cofactors(N, 0, R[q], d, f[q], F, Q[q])
            vPv[q] = N[6, 6, 0] * f[q] ** 2


@inlined  # type: ignore[misc, unused-ignore]
def _begin(R, S, origin, M, k):  # type: ignore[no-untyped-def]
    """M = camera from ground about its first point, in camera distances; returns that distance."""
    x, y, z = origin[0] - S[0], origin[1] - S[1], origin[2] - S[2]
    d = math.sqrt(x * x + y * y + z * z)
    for i in range(3):
        M[i, 0, k], M[i, 1, k], M[i, 2, k] = R[0, i], R[1, i], R[2, i]
        M[i, 3, k] = (R[0, i] * x + R[1, i] * y + R[2, i] * z) / d
    return d


@compiled  # type: ignore[misc, unused-ignore]
def _columns(image, ground, f, d, x, X):  # type: ignore[no-untyped-def]
    """x/f (2, n), and the ground (3, n) about its first point in camera distances."""
    a, b = 1.0 / f, 1.0 / d
    gx, gy, gz = ground[0]
    for i in range(len(image)):
        x[0, i], x[1, i] = image[i, 0] * a, image[i, 1] * a
    for i in range(len(image)):
        X[0, i], X[1, i], X[2, i] = (ground[i, 0] - gx) * b, (ground[i, 1] - gy) * b, (ground[i, 2] - gz) * b


@inlined  # type: ignore[misc, unused-ignore]
def _normal_equations(points, M, N):  # type: ignore[no-untyped-def]
    """Lower triangles of (A, l)'(A, l) of the photos in the lanes."""
    for r in range(7):
        for c in range(r + 1):
            for k in range(LANES):
                N[r, c, k] = 0.0
    for i in range(len(points)):
        for k in range(LANES):
            x, y, X, Y, Z = points[i, 0, k], points[i, 1, k], points[i, 2, k], points[i, 3, k], points[i, 4, k]
            a, b, c, l = _products(x, y, X, Y, Z, M, k)
            N[0, 0, k] += a[0]
            N[1, 0, k] += a[1]
            N[1, 1, k] += a[2]
            N[2, 0, k] += a[3]
            N[2, 1, k] += a[4]
            N[2, 2, k] += a[5]
            N[3, 0, k] += b[0]
            N[3, 1, k] += b[1]
            N[3, 2, k] += b[2]
            N[3, 3, k] += b[3]
            N[4, 0, k] += b[4]
            N[4, 2, k] += b[5]
            N[5, 0, k] += c[0]
            N[5, 1, k] += c[1]
            N[5, 3, k] += c[2]
            N[5, 4, k] += c[3]
            N[5, 5, k] += c[4]
            N[6, 0, k] += l[0]
            N[6, 1, k] += l[1]
            N[6, 2, k] += l[2]
            N[6, 3, k] += l[3]
            N[6, 4, k] += l[4]
            N[6, 5, k] += l[5]
            N[6, 6, k] += l[6]
    for k in range(LANES):
        N[4, 1, k], N[4, 3, k], N[4, 4, k], N[5, 2, k] = -N[3, 0, k], 0.0, N[3, 3, k], 0.0


@compiled  # type: ignore[misc, unused-ignore]
def _normal_equations_of_one(x, X, M, N):  # type: ignore[no-untyped-def]
    """Those of one photo, in every lane: points (2, n) and (3, n), sums in registers."""
    n00 = n10 = n11 = n20 = n21 = n22 = n30 = n31 = n32 = n33 = n40 = n42 = 0.0
    n50 = n51 = n53 = n54 = n55 = n60 = n61 = n62 = n63 = n64 = n65 = n66 = 0.0
    for i in range(x.shape[1]):
        a, b, c, l = _products(x[0, i], x[1, i], X[0, i], X[1, i], X[2, i], M, 0)
        n00 += a[0]
        n10 += a[1]
        n11 += a[2]
        n20 += a[3]
        n21 += a[4]
        n22 += a[5]
        n30 += b[0]
        n31 += b[1]
        n32 += b[2]
        n33 += b[3]
        n40 += b[4]
        n42 += b[5]
        n50 += c[0]
        n51 += c[1]
        n53 += c[2]
        n54 += c[3]
        n55 += c[4]
        n60 += l[0]
        n61 += l[1]
        n62 += l[2]
        n63 += l[3]
        n64 += l[4]
        n65 += l[5]
        n66 += l[6]
    for k in range(LANES):
        N[0, 0, k], N[1, 0, k], N[1, 1, k], N[2, 0, k], N[2, 1, k], N[2, 2, k] = n00, n10, n11, n20, n21, n22
        N[3, 0, k], N[3, 1, k], N[3, 2, k], N[3, 3, k] = n30, n31, n32, n33
        N[4, 0, k], N[4, 1, k], N[4, 2, k], N[4, 3, k], N[4, 4, k] = n40, -n30, n42, 0.0, n33
        N[5, 0, k], N[5, 1, k], N[5, 2, k], N[5, 3, k], N[5, 4, k], N[5, 5, k] = n50, n51, 0.0, n53, n54, n55
        N[6, 0, k], N[6, 1, k], N[6, 2, k], N[6, 3, k] = n60, n61, n62, n63
        N[6, 4, k], N[6, 5, k], N[6, 6, k] = n64, n65, n66


@inlined  # type: ignore[misc, unused-ignore]
def _products(x, y, X, Y, Z, M, k):  # type: ignore[no-untyped-def]
    """What a point adds to N: rows 0 ... 2; 3 and 4; 5; 6. N41 = -N30, N43 = N52 = 0, N44 = N33."""
    w = 1.0 / (M[2, 0, k] * X + M[2, 1, k] * Y + M[2, 2, k] * Z + M[2, 3, k])
    u = (M[0, 0, k] * X + M[0, 1, k] * Y + M[0, 2, k] * Z + M[0, 3, k]) * w
    v = (M[1, 0, k] * X + M[1, 1, k] * Y + M[1, 2, k] * Z + M[1, 3, k]) * w
    ex, ey = x + u, y + v
    uv, s, pu, pv = u * v, u * u + v * v, 1.0 + u * u, 1.0 + v * v
    wu, wv, ww = w * u, w * v, w * w
    a = uv * uv + pv * pv, -uv * (2.0 + s), pu * pu + uv * uv, -u, -v, s
    b = -w * uv, w * pu, -wv, ww, -w * pv, wu
    c = wv * (1.0 + s), -wu * (1.0 + s), -ww * u, -ww * v, ww * s
    l = uv * ex + pv * ey, -pu * ex - uv * ey, v * ex - u * ey, -w * ex, -w * ey, wu * ex + wv * ey, ex * ex + ey * ey
    return a, b, c, l


@inlined  # type: ignore[misc, unused-ignore]
def _factor(N):  # type: ignore[no-untyped-def]
    """L L' = A'A in place of A'A, the diagonal of L as its reciprocal, and y = L^-1 A'l in place of A'l."""
    for j in range(6):
        for k in range(LANES):
            N[j, j, k] = 1.0 / math.sqrt(N[j, j, k])
        for i in range(j + 1, 7):
            for k in range(LANES):
                N[i, j, k] *= N[j, j, k]
            for c in range(j + 1, min(i, 5) + 1):
                for k in range(LANES):
                    N[i, c, k] -= N[i, j, k] * N[c, j, k]


@inlined  # type: ignore[misc, unused-ignore]
def _solve(N, step, size):  # type: ignore[no-untyped-def]
    """step = L'^-1 y, size = y'y."""
    size[:] = 0.0
    for i in range(5, -1, -1):
        for k in range(LANES):
            step[i, k] = N[6, i, k]
            size[k] += N[6, i, k] * N[6, i, k]
        for c in range(i + 1, 6):
            for k in range(LANES):
                step[i, k] -= N[c, i, k] * step[c, k]
        for k in range(LANES):
            step[i, k] *= N[i, i, k]


@inlined  # type: ignore[misc, unused-ignore]
def _move(M, step, moved):  # type: ignore[no-untyped-def]
    """P_camera <- E P_camera + t, E = I + 2 ([c]x + [c]x^2) / (1 + c'c), c = r/2; gives the sum of |r| and |t|."""
    for j in range(4):
        for k in range(LANES):
            x, y, z = 0.5 * step[0, k], 0.5 * step[1, k], 0.5 * step[2, k]
            a = 2.0 / (1.0 + x * x + y * y + z * z)
            X, Y, Z = M[0, j, k], M[1, j, k], M[2, j, k]
            cx, cy, cz = y * Z - z * Y, z * X - x * Z, x * Y - y * X
            M[0, j, k] += a * (cx + y * cz - z * cy)
            M[1, j, k] += a * (cy + z * cx - x * cz)
            M[2, j, k] += a * (cz + x * cy - y * cx)
    for k in range(LANES):
        M[0, 3, k] += step[3, k]
        M[1, 3, k] += step[4, k]
        M[2, 3, k] += step[5, k]
        moved[k] = abs(step[0, k]) + abs(step[1, k]) + abs(step[2, k])
        moved[k] += abs(step[3, k]) + abs(step[4, k]) + abs(step[5, k])


@compiled  # type: ignore[misc, unused-ignore]
def _is_regular(N, k):  # type: ignore[no-untyped-def]
    """Is enough left of each diagonal element of A'A = L L'? The diagonal of L is kept as its reciprocal."""
    is_regular = True
    for i in range(6):
        pivot = 1.0 / N[i, i, k] ** 2
        whole = pivot
        for j in range(i):
            whole += N[i, j, k] ** 2
        is_regular = is_regular and pivot > SINGULAR * whole
    return is_regular


@compiled  # type: ignore[misc, unused-ignore]
def _in_front(X, M, k):  # type: ignore[no-untyped-def]
    a, b, c, d = M[2, 0, k], M[2, 1, k], M[2, 2, k], M[2, 3, k]
    behind = 0
    for i in range(X.shape[1]):
        behind += a * X[0, i] + b * X[1, i] + c * X[2, i] + d >= 0.0
    return behind == 0


@compiled  # type: ignore[misc, unused-ignore]
def _pose(M, k, origin, d, R, S):  # type: ignore[no-untyped-def]
    for j in range(3):
        S[j] = origin[j]
        for i in range(3):
            R[j, i] = M[i, j, k]
            S[j] -= d * M[i, j, k] * M[i, 3, k]


@compiled  # type: ignore[misc, unused-ignore]
def _cofactors(L, k, R, d, f, F, Q):  # type: ignore[no-untyped-def]
    """Of (r, S) in the ground's axes: F F', L F' = (R, R d)' / f by forward substitution."""
    for j in range(6):
        for i in range(6):
            total = 0.0
            if i < 3 and j < 3:
                total = R[j, i] / f
            elif i >= 3 and j >= 3:
                total = R[j - 3, i - 3] * d / f
            for c in range(i):
                total -= L[i, c, k] * F[j, c]
            F[j, i] = total * L[i, i, k]
    for i in range(6):
        for j in range(i + 1):
            total = 0.0
            for c in range(6):
                total += F[i, c] * F[j, c]
            Q[i, j] = total
            Q[j, i] = total
