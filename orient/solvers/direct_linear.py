"""(x/f, y/f, -1) x M (P, 1) = 0, M = R'[I | -S]: the direct linear transformation of control with relief."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

POINTS_NEEDED = 6


def direct_linear_resection(image: FloatArray, ground: FloatArray, f_mm: float) -> list[tuple[FloatArray, FloatArray]]:
    """The (R, S) whose twelve coefficients M (3, 4) leave the smallest algebraic error; R is the rotation nearest M.

    `image` (n, 2) [mm], principal point at 0; `ground` (n, 3), right-handed, n >= 6, about its centroid and of size
    one. At most one pair; none for fewer points, or where M has no rotation in it. Points on a plane leave M
    undetermined: the pair is then any. Mirrored data give a pair with the points behind the camera.
    Source: Abdel-Aziz and Karara (1971), with the interior orientation known; nearest rotation by Schönemann (1966).
    """
    if len(image) < POINTS_NEEDED:
        return []
    rays, places = image / f_mm, np.column_stack([ground, np.ones(len(ground))])
    blank = np.zeros_like(places)
    A = np.vstack(
        [
            np.hstack([places, blank, rays[:, :1] * places]),
            np.hstack([blank, places, rays[:, 1:] * places]),
        ]
    )
    M = np.linalg.svd(np.linalg.qr(A, mode="r"))[2][-1].reshape(3, 4)
    size = np.cbrt(np.linalg.det(M[:, :3]))
    if not abs(size) > np.finfo(float).eps:
        return []
    U, _, Vt = np.linalg.svd(M[:, :3] / size)
    return [((U @ Vt).T, -np.linalg.solve(M[:, :3], M[:, 3]))]
