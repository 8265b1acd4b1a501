"""Covariances of ground points in their own horizon and in the scale of the image, as columns of the project file."""

from dataclasses import dataclass

import numpy as np

from orient.pipeline.frames import Frame
from orient.pipeline.tables import Array, by_names
from orient.solvers.ground_covariance import RayJacobians, error_ellipses, ground_covariance
from orient.units import DEGREES_PER_RADIAN

ON_GROUND = ("XX", "XY", "YY")
IN_IMAGE = ("xx", "xy", "yy")


@dataclass(frozen=True, slots=True)
class PlanCovariance:
    """Three independent parts of the covariance on the ground (n, 2, 2) [m^2], axes X and Y of each point's horizon.

    `scale` B = d(x, y)/d(X, Y) (n, 2, 2) [mm/m]: B K B' is a covariance in the scale of the image.
    """

    orientation: Array
    reading: Array
    height: Array
    scale: Array

    @property
    def total(self) -> Array:
        return self.orientation + self.reading + self.height

    def in_image(self, covariance: Array) -> Array:
        """B K B' (n, 2, 2) [mm^2]."""
        return np.asarray(self.scale @ covariance @ self.scale.transpose(0, 2, 1))


def plan_covariance(
    jacobians: RayJacobians, axes: Array, elements: Array, reading: Array, height_variance: Array
) -> PlanCovariance:
    """E K E' of each part, B = (E J)^-1 with the horizon axes E (n, 2, 3); every ray must meet its height.

    `elements` (6, 6) covariance of the orientation, `reading` (n, 2, 2) [mm^2], `height_variance` (n,) [m^2].
    """
    found = ground_covariance(jacobians, elements, reading, height_variance)
    turned = axes.transpose(0, 2, 1)
    orientation, by_reading, height = (
        np.asarray(axes @ part @ turned) for part in (found.orientation, found.reading, found.height)
    )
    return PlanCovariance(orientation, by_reading, height, np.asarray(np.linalg.inv(axes @ jacobians.J)))


def horizon(frame: Frame, up: Array) -> Array:
    """(n, 2, 3) unit vectors X (grid north) and Y (grid east) in the horizon of each point, right-handed frame."""
    x_axis = frame.right_handed(np.array([1.0, 0.0, 0.0]))
    level = x_axis - (up @ x_axis)[:, None] * up
    first = level / np.linalg.norm(level, axis=1)[:, None]
    second = np.cross(up, first) * np.linalg.det(frame.partner)
    return np.stack([first, second], axis=1)


def ground_columns(plan: PlanCovariance) -> dict[str, Array]:
    """The three parts, the standard deviations and the ellipse on the ground, one value per point in each column."""
    total = plan.total
    return {
        **_part("K", ON_GROUND, "m2", plan.orientation),
        **_part("reading", ON_GROUND, "m2", plan.reading),
        **_part("height", ON_GROUND, "m2", plan.height),
        "sigma_X_m": np.sqrt(total[:, 0, 0]),
        "sigma_Y_m": np.sqrt(total[:, 1, 1]),
        **_ellipse(total, "m", "azimuth"),
    }


def image_columns(plan: PlanCovariance) -> dict[str, Array]:
    """The part of the orientation, the standard deviations and the ellipse in the scale of the image, by column."""
    K, total = plan.in_image(plan.orientation), plan.in_image(plan.total)
    return {
        **_part("K", IN_IMAGE, "mm2", K),
        "sigma_x_mm": np.sqrt(total[:, 0, 0]),
        "sigma_y_mm": np.sqrt(total[:, 1, 1]),
        **_ellipse(total, "mm", "direction"),
    }


def scale_columns(plan: PlanCovariance) -> dict[str, Array]:
    """B, element by element, by column."""
    return by_names(("dx_dX_mm_m", "dx_dY_mm_m", "dy_dX_mm_m", "dy_dY_mm_m"), plan.scale.reshape(-1, 4))


def _part(name: str, axes: tuple[str, str, str], unit: str, covariance: Array) -> dict[str, Array]:
    return by_names([f"{name}_{pair}_{unit}" for pair in axes], covariance[:, *np.triu_indices(2)])


def _ellipse(covariance: Array, unit: str, angle: str) -> dict[str, Array]:
    a, b, azimuth = error_ellipses(covariance).T
    return {f"ellipse_a_{unit}": a, f"ellipse_b_{unit}": b, f"ellipse_{angle}_deg": azimuth * DEGREES_PER_RADIAN}
