"""x_cv = exp([rvec]x) P + tvec: the exterior orientation as OpenCV writes it, with its covariance.

OpenCV's camera looks along +z, x along the columns and y along the rows of the image: x_cv = D R'(P - S) with
R = ground_from_image and D = diag(s_x, s_y, -1), s_x s_y = -1: the directions of the columns and rows in the image axes
(+1, -1 for a positive with columns to the right and rows downwards).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.geometry.rotation import cross_matrix, quaternion_from_matrix

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class OpencvExterior:
    """rvec (3,) [rad], tvec (3,) [m] and J (6, 6) = d(rvec, tvec)/d(r, S)."""

    rvec: Array
    tvec: Array
    jacobian: Array


def opencv_exterior(rotation: ArrayLike, station: ArrayLike, axes: ArrayLike) -> OpencvExterior:
    """rvec = log(D R'), tvec = -D R' S of R (3, 3), S (3,) [m] and the diagonal `axes` (3,) of D, det D = +1.

    With r the small rotation about the ground axes, R_new = exp([r]x) R:

        D R_new' = exp([phi]x) D R',  phi = -D R' r
        d rvec = J_l(rvec)^-1 phi,    d tvec = phi x tvec - D R' dS

    Derived here; central differences in the tests.
    """
    turn = np.asarray(axes, dtype=np.float64)[:, None] * np.asarray(rotation, dtype=np.float64).T
    rvec, tvec = rotation_log(turn), -turn @ np.asarray(station, dtype=np.float64)
    J = np.zeros((6, 6))
    J[:3, :3] = -left_jacobian_inverse(rvec) @ turn
    J[3:, :3] = cross_matrix(tvec) @ turn
    J[3:, 3:] = -turn
    return OpencvExterior(rvec, tvec, J)


def rotation_log(rotation: ArrayLike) -> Array:
    """r (3,) with exp([r]x) = R and |r| <= pi, of an orthonormal R (3, 3) with det R = +1."""
    w, *vector = quaternion_from_matrix(rotation).tolist()
    sine = math.hypot(*vector)
    # 2 atan2(s, w)/s tends to 2/w = 2
    factor = 2.0 * math.atan2(sine, w) / sine if sine > 0.0 else 2.0
    return factor * np.array(vector)


def left_jacobian_inverse(r: ArrayLike) -> Array:
    """J_l^-1 = I - [r]x/2 + (1 - (t/2) cot(t/2))/t^2 [r]x^2, t = |r|: dr (3, 3) by the phi of exp([phi]x) exp([r]x).

    Holds up to a half turn, beyond which `rotation_log` does not go. Source: F. Bullo, R. Murray, 1995.
    """
    vector = np.asarray(r, dtype=np.float64)
    t = float(np.linalg.norm(vector))
    S = cross_matrix(vector)
    # the series stands for a difference that loses its digits below a hundredth
    factor = (1 - 0.5 * t / math.tan(0.5 * t)) / t**2 if t > 1e-2 else 1 / 12 + t**2 / 720
    result: Array = np.eye(3) - 0.5 * S + factor * (S @ S)
    return result
