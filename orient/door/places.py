"""Places on the ground and in the image, for many points at once, with covariance."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.solvers.ground_covariance import error_ellipses
from orient.units import DEGREES_PER_RADIAN

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class GroundPlaces:
    """Where readings meet the ground; unpacks into points and covariances. NaN where a ray meets no ground.

    points          (n, 3) [m] of T': X grid north, Y grid east, Z up; of local ground as it was given
    covariances     (n, 3, 3) [m^2] in the same axes: all parts together
    orientation, reading, height   (n, 3, 3) [m^2] the parts: what all points share, own reading, own height
    plan            (n, 2, 2) [m^2] of X (grid north) and Y (grid east) in each point's own horizon
    """

    points: Array
    covariances: Array
    orientation: Array
    reading: Array
    height: Array
    plan: Array

    def __iter__(self) -> Iterator[Array]:
        yield self.points
        yield self.covariances

    @property
    def ellipses(self) -> Array:
        """(n, 3): semi-axes a >= b [m] of the standard error ellipse of the plan, azimuth of a from X to Y [deg]."""
        return error_ellipses(self.plan) * [1.0, 1.0, DEGREES_PER_RADIAN]


_NONE = np.empty((0, 3, 3))
NO_GROUND = GroundPlaces(_NONE[:, 0], _NONE, _NONE, _NONE, _NONE, _NONE[:, :2, :2])
"""Where no readings meet the ground."""


@dataclass(frozen=True, slots=True)
class ImagePlaces:
    """Where ground points are seen; unpacks into xy and covariances. NaN where a point is not in the photo.

    xy              (n, 2) px or mm, as it was asked
    covariances     (n, 2, 2) of the place, in the same unit; the error of a reading made there comes on top
    """

    xy: Array
    covariances: Array

    def __iter__(self) -> Iterator[Array]:
        yield self.xy
        yield self.covariances
