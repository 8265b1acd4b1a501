"""Rows of `ground_accuracy`: a grid over the frame, how sure a new ground point would be at each place of it."""

from dataclasses import replace

import numpy as np

from orient.geometry.collinearity import image_ray
from orient.geometry.frame_centre import frame_centre
from orient.geometry.vertical_photo import grid_layout
from orient.pipeline.frames import Frame
from orient.pipeline.ground_budget import SeenImage
from orient.pipeline.oriented import Oriented
from orient.pipeline.plan_covariance import ground_columns, horizon, image_columns, plan_covariance
from orient.pipeline.tables import Array, by_names, required
from orient.solvers.ground_covariance import ray_at_height, ray_at_height_jacobians
from orient.store.format import current_format
from orient.values import Columns, Row

TABLE = "ground_accuracy"
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
) -> list[Row]:
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
    stored = frame.right_handed(points[met])
    on_ground = ground_columns(plan)
    is_small = np.max(np.abs(list(on_ground.values())), axis=0) < LARGEST
    rows = Columns({**by_names(("X_m", "Y_m", "Z_m"), stored), **on_ground, **image_columns(plan)})
    found = {i: row for i, row, small in zip(met.tolist(), rows, is_small, strict=True) if small}
    side, unseen = round(len(places) ** 0.5), dict.fromkeys(_columns())
    return [
        {**unseen, "line": i // side + 1, "place": i % side + 1, "x_mm": float(x), "y_mm": float(y), **found.get(i, {})}
        for i, (x, y) in enumerate(places)
    ]


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


def _columns() -> list[str]:
    return [name for name in current_format().tables[TABLE].names if name != "run_id"]
