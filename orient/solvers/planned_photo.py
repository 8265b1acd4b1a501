"""P = S + u t: a photo that is not yet measured, with its control where the rays meet the ground."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError
from orient.geometry.rotation import rotation_exp
from orient.solvers.ground_covariance import ray_at_height
from orient.solvers.ground_points import ground_knowledge
from orient.solvers.resection_checks import check_control
from orient.words import counted

FloatArray = NDArray[np.float64]

UP = np.array([0.0, 0.0, 1.0])
POINTS_NEEDED = 3
VERTICAL = 1e-12


@dataclass(frozen=True, slots=True)
class Sigmas:
    """A-priori standard deviations: reading of an image coordinate [mm], plan and height of the control [m]."""

    image_mm: float
    control_m: float = 0.0
    height_m: float = 0.0


@dataclass(frozen=True, slots=True)
class PlannedPhoto:
    """A photo that is not yet measured: where it stands, where its control will lie, how well all will be known.

    `image` (n, 2) [mm] from the principal point, `ground` (n, 3) [m] on the rays, right-handed, Z up; `rotation`
    R = ground_from_image; the control covariance is diag(control^2, control^2, height^2).
    """

    names: tuple[str, ...]
    image: FloatArray
    ground: FloatArray
    station: FloatArray
    rotation: FloatArray
    f_mm: float
    sigmas: Sigmas

    @property
    def is_normal_case(self) -> bool:
        """Vertical, flat and with errorless control: the case of seed 003."""
        is_vertical = bool(np.max(np.abs(self.rotation - np.eye(3))) <= VERTICAL)
        is_flat = bool(np.ptp(self.ground[:, 2]) <= VERTICAL * float(self.station[2]))
        return is_vertical and is_flat and self.sigmas.control_m == 0 and self.sigmas.height_m == 0


def planned_photo(
    image: FloatArray,
    names: Sequence[str],
    f_mm: float,
    height_m: float,
    sigmas: Sigmas,
    *,
    relief: FloatArray | None = None,
    tilt: float = 0.0,
) -> PlannedPhoto:
    """P = S + u t: control where the rays of `image` (n, 2) [mm] meet the ground, from a station at (0, 0, height).

    `relief` (n,): heights dZ [m] of the control above the mean ground Z = 0; `tilt` [rad]: the camera looks that far
    away from straight down, towards its own +y. X runs along x, Y along y of the vertical photo. Raises GeometryError
    for rays that miss their height, fewer than three points, coinciding points, points on a line.
    """
    if len(image) < POINTS_NEEDED:
        hint = "Plan at least 4, so that errors can be found."
        raise GeometryError(f"The layout has {counted(len(image), 'point')}, an orientation needs at least 3.", hint)
    rotation, station = rotation_exp([tilt, 0.0, 0.0]), np.array([0.0, 0.0, height_m])
    heights = np.zeros((len(image), 3))
    heights[:, 2] = 0.0 if relief is None else relief
    ground = ray_at_height(image, station, rotation, f_mm, heights, np.tile(UP, (len(image), 1)))
    missed = ~np.isfinite(ground).all(axis=1)
    if missed.any():
        name = names[int(np.argmax(missed))]
        hint = "Choose points below the horizon and below the camera, or a smaller tilt."
        raise GeometryError(f"The ray of point {name} does not meet the ground at its height.", hint)
    cofactors = np.tile(np.eye(2), (len(image), 1, 1))
    check_control(image, cofactors, ground_knowledge(ground, None, None), np.full(len(image), True), names)
    return PlannedPhoto(tuple(names), image, ground, station, rotation, f_mm, sigmas)
