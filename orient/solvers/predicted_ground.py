"""K = C Q C' + J sigma^2 J' + h sigma_H^2 h': the accuracy of new ground points over the frame of a planned photo."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError
from orient.solvers import mishchenko
from orient.solvers.ground_covariance import (
    GroundCovariance,
    RayJacobians,
    ray_at_height,
    ray_at_height_jacobians,
)
from orient.solvers.planned_photo import UP, PlannedPhoto
from orient.solvers.predicted_orientation import Prediction, named_elements

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class GroundMap:
    """Accuracy of new ground points over the frame.

    `image` (m, 2) [mm], `ground` (m, 3) [m] where the rays meet the mean ground, NaN for rays that do not; three
    independent parts of the covariance.
    """

    image: FloatArray
    ground: FloatArray
    jacobians: RayJacobians = field(repr=False)
    covariance: GroundCovariance

    @property
    def met(self) -> NDArray[np.bool_]:
        """Places (m,) whose ray meets the ground."""
        return self.jacobians.determined

    @property
    def mean_sigma(self) -> float:
        """sqrt(mean of (sigma_X^2 + sigma_Y^2) / 2) over the places that see the ground [m]."""
        return float(np.sqrt(np.mean(self._plan_variance(self.covariance.total))))

    def _plan_variance(self, covariance: FloatArray) -> FloatArray:
        return np.asarray(0.5 * (covariance[self.met, 0, 0] + covariance[self.met, 1, 1]))


def ground_map(
    photo: PlannedPhoto, prediction: Prediction, image: FloatArray, height_sigma_m: float = 0.0
) -> GroundMap:
    """K = C Q C' + J sigma^2 J' + h sigma_H^2 h' of new points at `image` (m, 2) [mm], on the mean ground Z = 0.

    `height_sigma_m`: of the heights on which new points are found. Raises GeometryError when no ray meets the ground.
    """
    up = np.tile(UP, (len(image), 1))
    ground = ray_at_height(image, photo.station, photo.rotation, photo.f_mm, np.zeros((len(image), 3)), up)
    jacobians = ray_at_height_jacobians(ground, photo.station, photo.rotation, photo.f_mm, up)
    if not jacobians.determined.any():
        raise GeometryError("The photo sees no ground: every ray runs above the horizon.", "Choose a smaller tilt.")
    root = jacobians.C @ prediction.factor
    reading = photo.sigmas.image_mm**2 * jacobians.J @ jacobians.J.transpose(0, 2, 1)
    height = height_sigma_m**2 * jacobians.h[:, :, None] * jacobians.h[:, None, :]
    covariance = GroundCovariance(root @ root.transpose(0, 2, 1), reading, height)
    return GroundMap(image, ground, jacobians, covariance)


def ground_by_use(photo: PlannedPhoto, prediction: Prediction, ground: GroundMap) -> dict[str, float]:
    """Mean ground sigma [m] from the orientation alone if all six elements, or less of their covariance, were used.

    Keys: `six elements` (right), `standard deviations only` (the diagonal), `position only`, `angles only`.
    """
    _, J = named_elements(photo.rotation)
    C = ground.jacobians.C[ground.met, :2] @ np.linalg.inv(J)
    groups = {"position only": (0, 1, 2), "angles only": (3, 4, 5)}
    full, diagonal, alone = mishchenko.variance_of_uses(C, prediction.named_factor, groups)
    variances = {"six elements": full, "standard deviations only": diagonal, **alone}
    return {use: float(np.sqrt(np.mean(variance))) for use, variance in variances.items()}
