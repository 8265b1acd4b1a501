"""The loops of `lean_similarity` and of the ground covariances, compiled by numba (extra `orient[fast]`).

Points come as rows and are computed as columns, a block of them at a time that stays in the processor's cache: only
loops over columns become vector instructions.
"""

from collections.abc import Callable
from functools import cache

import numpy as np

from orient.solvers.compiling import compiled, inlined

BLOCK = 128


@inlined  # type: ignore[misc, unused-ignore]
def _columns(points, begin, origin, columns, row):  # type: ignore[no-untyped-def]
    """Three rows of `columns`: a block of points (n, 3) from their origin; returns how many there are."""
    m = min(BLOCK, len(points) - begin)
    ox, oy, oz = origin[0], origin[1], origin[2]
    for i in range(m):
        columns[row, i] = points[begin + i, 0] - ox
        columns[row + 1, i] = points[begin + i, 1] - oy
        columns[row + 2, i] = points[begin + i, 2] - oz
    return m


@inlined  # type: ignore[misc, unused-ignore]
def _scene(model, ground, model_centre, ground_centre, weights, begin, columns):  # type: ignore[no-untyped-def]
    """x, P, p as seven rows of `columns`; no weights are an empty array, and then the last row stays as it is."""
    m = _columns(model, begin, model_centre, columns, 0)
    _columns(ground, begin, ground_centre, columns, 3)
    if len(weights):
        for i in range(m):
            columns[6, i] = weights[begin + i]
    return m


@compiled  # type: ignore[misc, unused-ignore]
def similarity_moments(model, ground, model_centre, ground_centre, weights):  # type: ignore[no-untyped-def]
    """Upper triangle of sum p x x', sum p x P' by rows, sum p |P|^2, sum p x, sum p P, sum p: 23 numbers."""
    columns = np.ones((7, BLOCK))
    sx = sy = sz = sX = sY = sZ = sp = 0.0
    xx = xy = xz = yy = yz = zz = a = b = c = d = e = f = g = h = j = PP = 0.0
    for begin in range(0, len(model), BLOCK):
        m = _scene(model, ground, model_centre, ground_centre, weights, begin, columns)
        for i in range(m):
            x, y, z, X, Y, Z = columns[0, i], columns[1, i], columns[2, i], columns[3, i], columns[4, i], columns[5, i]
            p = columns[6, i]
            px, py, pz = p * x, p * y, p * z
            xx += px * x
            xy += px * y
            xz += px * z
            yy += py * y
            yz += py * z
            zz += pz * z
            a += px * X
            b += px * Y
            c += px * Z
            d += py * X
            e += py * Y
            f += py * Z
            g += pz * X
            h += pz * Y
            j += pz * Z
            PP += p * (X * X + Y * Y + Z * Z)
            sx += px
            sy += py
            sz += pz
            sX += p * X
            sY += p * Y
            sZ += p * Z
            sp += p
    return np.array([xx, xy, xz, yy, yz, zz, a, b, c, d, e, f, g, h, j, PP, sx, sy, sz, sX, sY, sZ, sp])


@compiled  # type: ignore[misc, unused-ignore]
def similarity_sums(model, ground, model_centre, ground_centre, weights, arm):  # type: ignore[no-untyped-def]
    """sum p x v' (3, 3) by rows, sum p v, v'Pv of v = arm x - P: 13 numbers."""
    columns = np.ones((7, BLOCK))
    a00, a01, a02 = arm[0]
    a10, a11, a12 = arm[1]
    a20, a21, a22 = arm[2]
    a = b = c = d = e = f = g = h = j = sx = sy = sz = vPv = 0.0
    for begin in range(0, len(model), BLOCK):
        m = _scene(model, ground, model_centre, ground_centre, weights, begin, columns)
        for i in range(m):
            x, y, z, p = columns[0, i], columns[1, i], columns[2, i], columns[6, i]
            vx = a00 * x + a01 * y + a02 * z - columns[3, i]
            vy = a10 * x + a11 * y + a12 * z - columns[4, i]
            vz = a20 * x + a21 * y + a22 * z - columns[5, i]
            px, py, pz = p * vx, p * vy, p * vz
            a += x * px
            b += x * py
            c += x * pz
            d += y * px
            e += y * py
            f += y * pz
            g += z * px
            h += z * py
            j += z * pz
            sx += px
            sy += py
            sz += pz
            vPv += vx * px + vy * py + vz * pz
    return np.array([a, b, c, d, e, f, g, h, j, sx, sy, sz, vPv])


@compiled  # type: ignore[misc, unused-ignore]
def covariances(points, station, L, up, grazing, K):  # type: ignore[no-untyped-def]
    """K (n, 3, 3), or (n, 2, 2) of the plan, of `covariance_by_orientation`; `up` (1, 3) or (n, 3)."""
    columns, packed, nowhere = np.empty((6, BLOCK)), np.empty((6, BLOCK)), np.zeros(3)
    for begin in range(0, len(points), BLOCK):
        m = _columns(points, begin, station, columns, 0)
        if len(up) > 1:
            _columns(up, begin, nowhere, columns, 3)
        elif begin == 0:
            for i in range(BLOCK):
                columns[3, i], columns[4, i], columns[5, i] = up[0, 0], up[0, 1], up[0, 2]
        _packed(m, columns, L, grazing, packed)
        for i in range(m):
            K[begin + i, 0, 0] = packed[0, i]
            K[begin + i, 0, 1] = K[begin + i, 1, 0] = packed[1, i]
            K[begin + i, 1, 1] = packed[2, i]
        if K.shape[1] == 3:
            for i in range(m):
                K[begin + i, 0, 2] = K[begin + i, 2, 0] = packed[3, i]
                K[begin + i, 1, 2] = K[begin + i, 2, 1] = packed[4, i]
                K[begin + i, 2, 2] = packed[5, i]


@inlined  # type: ignore[misc, unused-ignore]
def _packed(m, columns, L, grazing, packed):  # type: ignore[no-untyped-def]
    """F F' as rows XX, XY, YY, XZ, YZ, ZZ of `packed`: F = (1 - h n')(dS + r x arm), (r, dS) the columns of L."""
    for i in range(m):
        x, y, z, nx, ny, nz = columns[0, i], columns[1, i], columns[2, i], columns[3, i], columns[4, i], columns[5, i]
        fall = nx * x + ny * y + nz * z
        is_level = not fall * fall > grazing * grazing * (x * x + y * y + z * z)
        per_fall = 1.0 / (np.nan if is_level else fall)
        hx, hy, hz = x * per_fall, y * per_fall, z * per_fall
        xx = xy = yy = xz = yz = zz = 0.0
        for k in range(6):
            fx = L[3, k] + L[1, k] * z - L[2, k] * y
            fy = L[4, k] + L[2, k] * x - L[0, k] * z
            fz = L[5, k] + L[0, k] * y - L[1, k] * x
            w = nx * fx + ny * fy + nz * fz
            fx -= hx * w
            fy -= hy * w
            fz -= hz * w
            xx += fx * fx
            xy += fx * fy
            yy += fy * fy
            xz += fx * fz
            yz += fy * fz
            zz += fz * fz
        packed[0, i], packed[1, i], packed[2, i] = xx, xy, yy
        packed[3, i], packed[4, i], packed[5, i] = xz, yz, zz


@cache
def products_of_rows(unknowns: int) -> Callable[..., None]:
    """K_rr, K_rq, K_qq of the rows r, q of F = C L, C (n, rows, unknowns).

    The number of unknowns is a constant of the machine code: loops over them are none any more, and sums stay in
    registers.
    """

    @compiled  # type: ignore[misc, unused-ignore]
    def products(C, L, r, q, K):  # type: ignore[no-untyped-def]
        for n in range(len(C)):
            rr = rq = qq = 0.0
            for k in range(unknowns):
                f = g = 0.0
                for j in range(unknowns):
                    f += L[j, k] * C[n, r, j]
                    g += L[j, k] * C[n, q, j]
                rr += f * f
                rq += f * g
                qq += g * g
            K[n, r, r] = rr
            K[n, r, q] = K[n, q, r] = rq
            K[n, q, q] = qq

    return products  # type: ignore[no-any-return, unused-ignore]
