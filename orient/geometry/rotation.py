"""Rotations: `rotation` = R = ground_from_image; its columns are the image axes x, y, z seen in the ground frame.

The ground frame is right-handed with Z up; the camera's z points away from the ground. Three views of one matrix:

* aok (Lobanov): R = A_alpha(Y) A_omega(X) A_kappa(Z), EQUATIONS 4.3;
* opk (photogrammetric): M = R' = M_kappa M_phi M_omega;
* the unit quaternion (w, x, y, z), w >= 0, of R: what is stored.

A small rotation r (3,) acts about the ground axes: R_new = exp([r]x) R. All angles are in radians.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

BLIND_COSINE = 0.1
"""Below this cosine of the middle angle an error of the rotation appears tenfold in the outer two angles."""


def matrix_from_aok(alpha: float, omega: float, kappa: float) -> Array:
    """R = A_alpha(Y) A_omega(X) A_kappa(Z) (3, 3), the nine cosines a1 ... c3 of Lobanov; angles in radians.

    alpha turns Z towards -X, omega turns Y towards Z, kappa turns X towards Y. Source: seed 004, EQUATIONS 4.3.
    """
    sa, ca = math.sin(alpha), math.cos(alpha)
    so, co = math.sin(omega), math.cos(omega)
    sk, ck = math.sin(kappa), math.cos(kappa)
    return np.array(
        [
            [ca * ck - sa * so * sk, -ca * sk - sa * so * ck, -sa * co],
            [co * sk, co * ck, -so],
            [sa * ck + ca * so * sk, -sa * sk + ca * so * ck, ca * co],
        ]
    )


def aok_from_matrix(rotation: ArrayLike) -> Array:
    """alpha = atan2(-a3, c3), omega = -asin(b3), kappa = atan2(b1, b2): (3,) radians, omega in [-pi/2, pi/2].

    In the blind view (omega = +-pi/2, the camera looks along the ground's Y axis) only alpha +- kappa is determined;
    kappa is then taken with the alpha found, so that the triple still gives back the matrix.
    """
    R = np.asarray(rotation, dtype=np.float64)
    alpha = math.atan2(-R[0, 2], R[2, 2])
    omega = math.atan2(-R[1, 2], math.hypot(R[0, 2], R[2, 2]))
    # row 1 of A_alpha' R is (cos kappa, -sin kappa, 0): never weaker than b1, b2, and defined in the blind view
    cosine, minus_sine = math.cos(alpha) * R[0, :2] + math.sin(alpha) * R[2, :2]
    return np.array([alpha, omega, math.atan2(-minus_sine, cosine)])


def matrix_from_opk(omega: float, phi: float, kappa: float) -> Array:
    """R = M', M = M_kappa M_phi M_omega (ground -> image): R = R_omega(X) R_phi(Y) R_kappa(Z) (3, 3); radians."""
    so, co = math.sin(omega), math.cos(omega)
    sp, cp = math.sin(phi), math.cos(phi)
    sk, ck = math.sin(kappa), math.cos(kappa)
    return np.array(
        [
            [cp * ck, -cp * sk, sp],
            [co * sk + so * sp * ck, co * ck - so * sp * sk, -so * cp],
            [so * sk - co * sp * ck, so * ck + co * sp * sk, co * cp],
        ]
    )


def opk_from_matrix(rotation: ArrayLike) -> Array:
    """omega = atan2(-m32, m33), phi = asin(m31), kappa = atan2(-m21, m11): (3,) radians, phi in [-pi/2, pi/2].

    In the blind view (phi = +-pi/2, the camera looks along the ground's X axis) only omega +- kappa is determined;
    kappa is then taken with the omega found, so that the triple still gives back the matrix.
    """
    R = np.asarray(rotation, dtype=np.float64)
    omega = math.atan2(-R[1, 2], R[2, 2])
    phi = math.atan2(R[0, 2], math.hypot(R[1, 2], R[2, 2]))
    # row 2 of R_omega' R is (sin kappa, cos kappa, 0)
    sine, cosine = math.cos(omega) * R[1, :2] + math.sin(omega) * R[2, :2]
    return np.array([omega, phi, math.atan2(sine, cosine)])


def quaternion_from_matrix(rotation: ArrayLike) -> Array:
    """q = (w, x, y, z) (4,) with w >= 0 and |q| = 1, of an orthonormal R (3, 3) with det R = +1.

    The largest of the four components is found first, so that nothing is divided by a small number. At a half turn
    (w = 0) the first component that is not zero is positive. Source: S. W. Shepperd, 1978.
    """
    (a, b, c), (d, e, f), (g, h, i) = np.asarray(rotation, dtype=np.float64).tolist()
    # 4 q q' from the elements of R; its rows are multiples of q
    rows = [
        [1 + a + e + i, h - f, c - g, d - b],
        [h - f, 1 + a - e - i, b + d, c + g],
        [c - g, b + d, 1 - a + e - i, f + h],
        [d - b, c + g, f + h, 1 - a - e + i],
    ]
    row = rows[max(range(4), key=lambda k: rows[k][k])]
    sign = next(math.copysign(1.0, component) for component in row if component != 0.0)
    unit: Array = np.array([sign * component for component in row]) / np.linalg.norm(row)
    return unit + 0.0  # no -0.0 in what is stored


def matrix_from_quaternion(quaternion: ArrayLike) -> Array:
    """R (3, 3) of q = (w, x, y, z); q is normalised first, so that stored digits may be rounded. q = 0 gives nan."""
    q = np.asarray(quaternion, dtype=np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):
        w, x, y, z = q / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def cross_matrix(r: ArrayLike) -> Array:
    """[r]x (..., 3, 3) with [r]x p = r x p, of r (..., 3)."""
    x, y, z = np.moveaxis(np.asarray(r, dtype=np.float64), -1, 0)
    S = np.zeros((*x.shape, 3, 3))
    S[..., 0, 1], S[..., 0, 2], S[..., 1, 2] = -z, y, -x
    S[..., 1, 0], S[..., 2, 0], S[..., 2, 1] = z, -y, x
    return S


def rotation_exp(r: ArrayLike) -> Array:
    """exp([r]x) = I + sin(t)/t [r]x + (1 - cos t)/t^2 [r]x^2, t = |r| (Rodrigues): (3, 3) of r (3,) in radians."""
    vector = np.asarray(r, dtype=np.float64)
    t = float(np.linalg.norm(vector))
    S = cross_matrix(vector)
    # np.sinc(u) = sin(pi u)/(pi u) is 1 at zero; (1 - cos t)/t^2 = sinc^2(t/2)/2 loses no digits for small t
    first, second = np.sinc(t / math.pi), 0.5 * np.sinc(t / (2 * math.pi)) ** 2
    result: Array = np.eye(3) + first * S + second * (S @ S)
    return result


def aok_by_rotation(rotation: ArrayLike) -> Array:
    """d(alpha, omega, kappa)/dr (3, 3) for R_new = exp([r]x) R, at r = 0.

        d alpha = -r2 - tan(om) (cos(al) r3 - sin(al) r1)
        d omega =  cos(al) r1 + sin(al) r3
        d kappa = (cos(al) r3 - sin(al) r1) / cos(om)

    Inverse of r = -d_alpha e_Y + d_omega A_alpha e_X + d_kappa A_alpha A_omega e_Z. Not finite in the blind view
    (cos omega = 0): ask `near_blind_aok` first.
    """
    alpha, omega, _ = aok_from_matrix(rotation)
    sa, ca = math.sin(alpha), math.cos(alpha)
    t, co = math.tan(omega), math.cos(omega)
    return np.array([[sa * t, -1.0, -ca * t], [ca, 0.0, sa], [-sa / co, 0.0, ca / co]])


def opk_by_rotation(rotation: ArrayLike) -> Array:
    """d(omega, phi, kappa)/dr (3, 3) for R_new = exp([r]x) R, at r = 0.

        d omega = r1 - tan(ph) (cos(om) r3 - sin(om) r2)
        d phi   = cos(om) r2 + sin(om) r3
        d kappa = (cos(om) r3 - sin(om) r2) / cos(ph)

    Inverse of r = d_omega e_X + d_phi R_omega e_Y + d_kappa R_omega R_phi e_Z. Not finite in the blind view
    (cos phi = 0): ask `near_blind_opk` first.
    """
    omega, phi, _ = opk_from_matrix(rotation)
    so, co = math.sin(omega), math.cos(omega)
    t, cp = math.tan(phi), math.cos(phi)
    return np.array([[1.0, so * t, -co * t], [0.0, co, so], [0.0, -so / cp, co / cp]])


def near_blind_aok(rotation: ArrayLike) -> bool:
    """True if cos(omega) < 0.1: the camera looks within 6 degrees of the ground's Y axis; alpha, kappa are weak."""
    R = np.asarray(rotation, dtype=np.float64)
    return math.hypot(R[0, 2], R[2, 2]) < BLIND_COSINE


def near_blind_opk(rotation: ArrayLike) -> bool:
    """True if cos(phi) < 0.1: the camera looks within 6 degrees of the ground's X axis; omega, kappa are weak."""
    R = np.asarray(rotation, dtype=np.float64)
    return math.hypot(R[1, 2], R[2, 2]) < BLIND_COSINE
