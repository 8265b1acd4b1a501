"""Points that were never in a list: where a reading meets the ground, where a ground point is seen, and how sure.

    on the ground:  dP = C de + J dx + h dH,      K = T Sigma T' + J Q_x J' + h sigma_H^2 h'
    in the image:   M dq = A_e de + A_P dP - U dc,  with M = dx/dq, U = dx/dc at a fixed ground point

e: the six elements; c: what was estimated of camera and interior orientation; Sigma: their covariance, with that
between them. The same as the stage `covariance` stores for the points of the lists (seed 003, (1)-(3)).
"""

from dataclasses import dataclass, replace

import numpy as np

from orient.geometry.collinearity import image_ray, partials_rotation
from orient.pipeline.frames import Frame
from orient.pipeline.ground_budget import ELEMENTS
from orient.pipeline.photo_model import PhotoModel, Seen
from orient.pipeline.plan_covariance import horizon
from orient.pipeline.tables import Array
from orient.solvers.ground_covariance import (
    GroundCovariance,
    ground_covariance,
    ray_at_height,
    ray_at_height_jacobians,
)

UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True)
class OnGround:
    """Places (n, 3) [m] and the three parts of their covariance (n, 3, 3) [m^2], in the stored frame (T' or local).

    `horizon` (n, 2, 3): X and Y of each place's own horizon in that frame. NaN where a ray meets no ground.
    """

    points: Array
    covariance: GroundCovariance
    horizon: Array


@dataclass(frozen=True, slots=True)
class InImage:
    """Image places (n, 2) [mm] of ground points and their covariance (n, 2, 2) [mm^2]; NaN: not in the photo."""

    xy: Array
    covariance: Array


def on_ground(
    model: PhotoModel, readings: Array, heights: Array, reading_covariance: Array, height_variance: Array
) -> OnGround:
    """Where `readings` (n, 2) [mm] meet the heights (n,) [m]: ellipsoidal, or Z of local ground.

    `reading_covariance` (n, 2, 2) [mm^2] a priori: it is scaled with sigma0 like that of the readings of the lists;
    `height_variance` (n,) [m^2].
    """
    seen, oriented, frame = model.seen(readings), model.oriented, model.frame
    points, up = _meet(model, seen.image, heights)
    jacobians = ray_at_height_jacobians(points, oriented.station, oriented.rotation, oriented.f_mm, up)
    jacobians = replace(jacobians, C=seen.through.jacobian(jacobians.C, jacobians.J))
    by_reading = seen.by_reading
    own = oriented.scale * by_reading @ reading_covariance @ by_reading.transpose(0, 2, 1)
    found = ground_covariance(jacobians, oriented.ray_covariance, own, height_variance)
    stored = (frame.right_handed_matrix(part) for part in (found.orientation, found.reading, found.height))
    axes = frame.right_handed(horizon(frame, up))
    return OnGround(frame.right_handed(points), GroundCovariance(*stored), axes)


def in_image(model: PhotoModel, ground: Array, ground_covariance: Array, as_reading: bool) -> InImage:
    """Where ground points (n, 3) of the stored frame are seen, with `ground_covariance` (n, 3, 3) [m^2] of their own.

    As readings [mm of the comparator], or as corrected image coordinates. The covariance is that of the place: the
    error of a reading made there comes on top.
    """
    places = model.frame.right_handed(ground)
    image, is_seen = model.project(places)
    xy, covariance = np.full((len(ground), 2), np.nan), np.full((len(ground), 2, 2), np.nan)
    if is_seen.any():
        readings = model.readings(image[is_seen])
        seen = model.seen(readings)
        own = model.frame.right_handed_matrix(ground_covariance[is_seen])
        spread = _image_covariance(model, seen, places[is_seen], own)
        if as_reading:
            back = np.linalg.inv(seen.by_reading)
            spread = back @ spread @ back.transpose(0, 2, 1)
        xy[is_seen], covariance[is_seen] = readings if as_reading else image[is_seen], spread
    return InImage(xy, covariance)


def _image_covariance(model: PhotoModel, seen: Seen, places: Array, own: Array) -> Array:
    """(n, 2, 2) of M dq, scale of the corrected image."""
    oriented = model.oriented
    A = partials_rotation(places, oriented.station, oriented.rotation, oriented.f_mm)
    T = np.concatenate([A[:, :, :ELEMENTS], -seen.through.by_unknowns], axis=2)
    by_point = A[:, :, ELEMENTS:]
    shared = T @ oriented.ray_covariance @ T.transpose(0, 2, 1)
    return np.asarray(shared + by_point @ own @ by_point.transpose(0, 2, 1))


def _meet(model: PhotoModel, image: Array, heights: Array) -> tuple[Array, Array]:
    """Points (n, 3) and their verticals (n, 3), right-handed; NaN where a ray meets no ground."""
    frame, oriented = model.frame, model.oriented
    if frame.is_local:
        up = np.tile(UP, (len(image), 1))
        return ray_at_height(image, oriented.station, oriented.rotation, oriented.f_mm, heights[:, None] * up, up), up
    points = frame.meet_heights(oriented.station, image_ray(image, oriented.rotation, oriented.f_mm), heights)
    return points, _verticals(frame, points)


def _verticals(frame: Frame, points: Array) -> Array:
    geographic = frame.geographic(frame.right_handed(points))
    return frame.right_handed(frame.from_horizon(*geographic[:, :2].T)[:, :, 2])
