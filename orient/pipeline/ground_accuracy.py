"""Rows of `ground_accuracy`: a grid over the frame, how sure a new ground point would be at each place of it."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orient.geometry.collinearity import image_ray
from orient.geometry.frame_centre import frame_centre
from orient.geometry.vertical_photo import grid_layout
from orient.pipeline.frames import Frame
from orient.pipeline.ground_budget import SeenImage
from orient.pipeline.oriented import Oriented
from orient.pipeline.plan_covariance import ground_columns, horizon, image_columns, plan_covariance
from orient.pipeline.tables import Array, by_names, nullable, required
from orient.solvers.ground_covariance import ray_at_height, ray_at_height_jacobians
from orient.values import Columns, Row

IntArray = NDArray[np.int64]
LARGEST = 1e14
"""Covariance [m^2] of a place that sees no ground but the horizon; the file holds numbers below 1e15."""
UP = np.array([0.0, 0.0, 1.0])


def frame_places(photo: Row, side: int) -> Array:
    """(side^2, 2) [mm] places over the frame, line by line from its top left corner, about the principal point.

    The lens distortion of the edge is left out.
    """
    grid = grid_layout(required(photo, "frame_width_mm"), required(photo, "frame_height_mm"), side, side)
    principal_point = np.array([required(photo, "x0_mm"), required(photo, "y0_mm")])
    return np.asarray(grid + np.array(frame_centre(photo)) - principal_point)


def map_rows(
    places: Array,
    through: SeenImage,
    oriented: Oriented,
    frame: Frame,
    height: float,
    reading: Array,
    height_sigma: float,
) -> Columns:
    """One row for each of `places` (side^2, 2) [mm]; ground columns are None where the ray meets no ground.

    `through`: the places through camera and interior orientation, whose errors all of them share.
    `height` [m] of the ground above the ellipsoid, or Z of local ground; `reading` (2, 2) [mm^2] covariance of a new
    image point; `height_sigma` [m] of the height on which a new point is found.
    """
    points, up = seen_ground(through.image, oriented.station, oriented.rotation, oriented.f_mm, frame, height)
    jacobians = ray_at_height_jacobians(points, oriented.station, oriented.rotation, oriented.f_mm, up)
    jacobians = replace(jacobians, C=through.jacobian(jacobians.C, jacobians.J))
    met = np.flatnonzero(jacobians.determined)
    plan = plan_covariance(
        jacobians.at(met.tolist()),
        horizon(frame, up[met]),
        oriented.ray_covariance,
        through.reading(np.tile(reading, (len(places), 1, 1)))[met],
        np.full(len(met), height_sigma**2),
    )
    on_ground = ground_columns(plan)
    is_small = np.max(np.abs(list(on_ground.values())), axis=0) < LARGEST
    found = {**by_names(("X_m", "Y_m", "Z_m"), frame.right_handed(points[met])), **on_ground, **image_columns(plan)}
    line, place = np.divmod(np.arange(len(places)), round(len(places) ** 0.5))
    return Columns(
        {
            "line": line + 1,
            "place": place + 1,
            **by_names(("x_mm", "y_mm"), places),
            **{name: _at_places(values[is_small], met[is_small], len(places)) for name, values in found.items()},
        }
    )


def _at_places(values: Array, at: IntArray, count: int) -> Any:
    """A column of all places, in which the others are not known."""
    column = np.full(count, np.nan)
    column[at] = values
    return nullable(column)


def seen_ground(
    places: Array, station: Array, rotation: Array, f_mm: float, frame: Frame, height: float
) -> tuple[Array, Array]:
    """Where rays of `places` (m, 2) [mm] meet the height: points (m, 3), verticals (m, 3), right-handed; NaN: sky."""
    if frame.is_local:
        up = np.tile(UP, (len(places), 1))
        return ray_at_height(places, station, rotation, f_mm, height * up, up), up
    geographic = frame.meet(station, image_ray(places, rotation, f_mm), height)
    up_in_frame = frame.from_horizon(*geographic[:, :2].T)[:, :, 2]
    return frame.right_handed(frame.from_geographic(*geographic.T)), frame.right_handed(up_in_frame)
