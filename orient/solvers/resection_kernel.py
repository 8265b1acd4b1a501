"""The sums of `resection_batch`, compiled by numba (extra `orient[fast]`)."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
N_SUMS = 25


def compiled_sums(
    image: FloatArray, ground: FloatArray, rotation: FloatArray, station: FloatArray, distance: FloatArray
) -> FloatArray:
    """As `photo_sums`."""
    return np.asarray(_sums(image, ground, rotation, station, distance))


# error_model: the default raises on division by zero, which forbids vector instructions
@njit(cache=True, fastmath={"reassoc", "contract", "arcp", "nsz"}, error_model="numpy")  # type: ignore[misc, unused-ignore]
def _sums(image, ground, rotation, station, distance):  # type: ignore[no-untyped-def]
    total = np.zeros((N_SUMS, len(image)))
    for p in range(len(image)):
        R, S, d = rotation[p], station[p], distance[p]
        a0 = a1 = a2 = a3 = a4 = a5 = a6 = a7 = a8 = a9 = a10 = a11 = a12 = a13 = a14 = a15 = a16 = 0.0
        g0 = g1 = g2 = g3 = g4 = g5 = e = 0.0
        for i in range(image.shape[1]):
            X, Y, Z = ground[p, i, 0] - S[0], ground[p, i, 1] - S[1], ground[p, i, 2] - S[2]
            inverse = 1.0 / (X * R[0, 2] + Y * R[1, 2] + Z * R[2, 2])
            u = (X * R[0, 0] + Y * R[1, 0] + Z * R[2, 0]) * inverse
            v = (X * R[0, 1] + Y * R[1, 1] + Z * R[2, 1]) * inverse
            w = d * inverse
            ex, ey = image[p, i, 0] + u, image[p, i, 1] + v
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
        sums = (
            a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11, a12, a13, a14, a15, a16, g0, g1, g2, g3, g4, g5,
            float(image.shape[1]), e,
        )  # fmt: skip
        for k in range(N_SUMS):
            total[k, p] = sums[k]
    return total
