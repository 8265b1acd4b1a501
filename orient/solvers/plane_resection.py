"""(x/f, y/f, -1) x H (a, b, 1) = 0, H = R'[e1, e2, c - S]: the orientation from control on a plane c + a e1 + b e2."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

POINTS_NEEDED = 4


def plane_resection(image: FloatArray, ground: FloatArray, f_mm: float) -> list[tuple[FloatArray, FloatArray]]:
    """The (R, S) of the projective map H (3, 3) from the plane that fits the points best to the image.

    `image` (n, 2) [mm], principal point at 0; `ground` (n, 3), right-handed, n >= 4. At most one pair, with the points
    in front of the camera; none for fewer points or for a line. Heights above the plane are passed over. In a narrow
    field the tilt of the plane is nearly free and may come out with the wrong sign.
    Source: Zhang (2000), section 3.1, with the interior orientation known.
    """
    if len(image) < POINTS_NEEDED:
        return []
    centre = ground.mean(axis=0)
    _, values, axes = np.linalg.svd(ground - centre, full_matrices=False)
    if not values[1] > np.finfo(float).eps * values[0]:
        return []
    frame = np.column_stack([axes[0], axes[1], np.cross(axes[0], axes[1])])
    H = _plane_to_rays(image / f_mm, (ground - centre) @ frame[:, :2])
    size = 0.5 * (np.linalg.norm(H[:, 0]) + np.linalg.norm(H[:, 1]))
    if not size > np.finfo(float).eps:
        return []
    H = H / size
    U, _, Vt = np.linalg.svd(np.column_stack([H[:, 0], H[:, 1], np.cross(H[:, 0], H[:, 1])]))
    turned = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
    R = frame @ turned.T
    return [(R, centre - R @ H[:, 2])]


def _plane_to_rays(rays: FloatArray, plane: FloatArray) -> FloatArray:
    """H (3, 3) with H (a, b, 1) along (x/f, y/f, -1), third component negative at the centroid."""
    places = np.column_stack([plane, np.ones(len(plane))])
    blank = np.zeros_like(places)
    A = np.vstack(
        [
            np.hstack([places, blank, rays[:, :1] * places]),
            np.hstack([blank, places, rays[:, 1:] * places]),
        ]
    )
    _, _, Vt = np.linalg.svd(np.linalg.qr(A, mode="r"))
    H = np.asarray(Vt[-1].reshape(3, 3))
    return -H if H[2, 2] > 0 else H
