"""The loops of `lean_similarity` and `covariance_by_orientation`, compiled by numba (extra `orient[fast]`)."""

import numpy as np
from numba import njit

# error_model: the default raises on division by zero, which forbids vector instructions
_compiled = njit(cache=True, fastmath={"reassoc", "contract", "arcp", "nsz"}, error_model="numpy")


@_compiled  # type: ignore[misc, unused-ignore]
def similarity_products(model, ground, model_centre, ground_centre, weights):  # type: ignore[no-untyped-def]
    """Upper triangle of sum p x x', sum p x P' by rows, sum p |P|^2: 16 numbers. No weights are an empty array."""
    cx, cy, cz = model_centre[0], model_centre[1], model_centre[2]
    dx, dy, dz = ground_centre[0], ground_centre[1], ground_centre[2]
    xx = xy = xz = yy = yz = zz = a = b = c = d = e = f = g = h = i = PP = 0.0
    for n in range(len(model)):
        p = weights[n] if len(weights) else 1.0
        x, y, z = model[n, 0] - cx, model[n, 1] - cy, model[n, 2] - cz
        X, Y, Z = ground[n, 0] - dx, ground[n, 1] - dy, ground[n, 2] - dz
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
        i += pz * Z
        PP += p * (X * X + Y * Y + Z * Z)
    return np.array([xx, xy, xz, yy, yz, zz, a, b, c, d, e, f, g, h, i, PP])


@_compiled  # type: ignore[misc, unused-ignore]
def similarity_sums(model, ground, model_centre, ground_centre, weights, arm):  # type: ignore[no-untyped-def]
    """sum p x v' (3, 3) by rows, sum p v, v'Pv of v = arm x - P: 13 numbers."""
    cx, cy, cz = model_centre[0], model_centre[1], model_centre[2]
    dx, dy, dz = ground_centre[0], ground_centre[1], ground_centre[2]
    a = b = c = d = e = f = g = h = i = sx = sy = sz = vPv = 0.0
    for n in range(len(model)):
        p = weights[n] if len(weights) else 1.0
        x, y, z = model[n, 0] - cx, model[n, 1] - cy, model[n, 2] - cz
        vx = arm[0, 0] * x + arm[0, 1] * y + arm[0, 2] * z - (ground[n, 0] - dx)
        vy = arm[1, 0] * x + arm[1, 1] * y + arm[1, 2] * z - (ground[n, 1] - dy)
        vz = arm[2, 0] * x + arm[2, 1] * y + arm[2, 2] * z - (ground[n, 2] - dz)
        px, py, pz = p * vx, p * vy, p * vz
        a += x * px
        b += x * py
        c += x * pz
        d += y * px
        e += y * py
        f += y * pz
        g += z * px
        h += z * py
        i += z * pz
        sx += px
        sy += py
        sz += pz
        vPv += vx * px + vy * py + vz * pz
    return np.array([a, b, c, d, e, f, g, h, i, sx, sy, sz, vPv])


@_compiled  # type: ignore[misc, unused-ignore]
def covariances(points, station, L, up, grazing, K):  # type: ignore[no-untyped-def]
    """K (n, 3, 3) of `covariance_by_orientation`; `up` (1, 3) or (n, 3)."""
    own = len(up) > 1
    for n in range(len(points)):
        x, y, z = points[n, 0] - station[0], points[n, 1] - station[1], points[n, 2] - station[2]
        m = n if own else 0
        nx, ny, nz = up[m, 0], up[m, 1], up[m, 2]
        fall = nx * x + ny * y + nz * z
        if not fall * fall > grazing * grazing * (x * x + y * y + z * z):
            fall = np.nan
        hx, hy, hz = x / fall, y / fall, z / fall
        xx = xy = xz = yy = yz = zz = 0.0
        for k in range(L.shape[1]):
            gx = L[3, k] + L[1, k] * z - L[2, k] * y
            gy = L[4, k] + L[2, k] * x - L[0, k] * z
            gz = L[5, k] + L[0, k] * y - L[1, k] * x
            w = nx * gx + ny * gy + nz * gz
            gx -= hx * w
            gy -= hy * w
            gz -= hz * w
            xx += gx * gx
            xy += gx * gy
            xz += gx * gz
            yy += gy * gy
            yz += gy * gz
            zz += gz * gz
        K[n, 0, 0] = xx
        K[n, 0, 1] = K[n, 1, 0] = xy
        K[n, 0, 2] = K[n, 2, 0] = xz
        K[n, 1, 1] = yy
        K[n, 1, 2] = K[n, 2, 1] = yz
        K[n, 2, 2] = zz
