"""Earth curvature: a control point on a map plane lies d^2/(2R) too high, its image (H-h) r^3/(2 R f^2) too far in.

Only for plane map coordinates with heights above the curved datum. Cartesian ground in three dimensions (topocentric,
geocentric) contains the curvature already. EQUATIONS 5.3.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.errors import GeometryError

Array = NDArray[np.float64]


def correction(xy: ArrayLike, f_mm: float, H_m: float, h_m: float, radius_m: float) -> Array:
    """+(H - h) r^2/(2 R f^2) x, likewise y: (n, 2) mm to ADD to xy (n, 2) mm, away from the principal point.

    H_m, h_m: camera and ground [m]; radius_m: R of the datum [m]. First order and for a near-vertical photo: from
    250 km, at r = 127 mm of f = 200 mm, it is 1.0114 mm where 1.0415 mm would be exact. A camera not above the ground
    raises GeometryError. Source: Manual of Photogrammetry; K. Kraus, Photogrammetrie.
    """
    if not H_m > h_m:
        raise GeometryError(
            f"earth curvature: the camera ({H_m:.1f} m) is not above the ground ({h_m:.1f} m)",
            "Correct the two heights in photo.toml, or leave [curvature] out.",
        )
    image = np.asarray(xy, dtype=np.float64)
    r2 = np.sum(image * image, axis=-1, keepdims=True)
    result: Array = (H_m - h_m) / (2.0 * radius_m * f_mm**2) * r2 * image
    return result


def needs_no_correction(ground_kind: str) -> GeometryError:
    """Why ground of the kind `crs` or `ellipsoid` is not corrected."""
    return GeometryError(
        f"earth curvature: topocentric coordinates (ground by {ground_kind}) already contain the curvature",
        "Leave [curvature] out of photo.toml; it is for local ground that is a map plane with heights.",
    )
