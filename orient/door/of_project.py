"""What the door reads from a project, and how its arguments become values of the floors below."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from orient.door.arguments import System
from orient.errors import UsageError
from orient.pipeline.frames import Frame, frame_of
from orient.pipeline.ground import ground_of
from orient.pipeline.photo_model import PhotoModel
from orient.pipeline.tables import required, single
from orient.store.project import Project, RunInfo
from orient.values import Tables

Array = NDArray[np.float64]


def version_of(project: Project, stage: str, version: int | None) -> RunInfo:
    """The named version of a stage, or its current one."""
    if version is not None:
        return project.run(stage, version)
    head = project.heads().get(stage)
    if head is None:
        raise UsageError(f"{stage} has no current version", "Compute it: photo.run()")
    return head


def stored_frame(tables: Mapping[str, Tables]) -> Frame:
    """The frame of the ground coordinates, from the tables of photo and topocentric."""
    return frame_of(single(tables["topocentric"], "topocentric_frame"), ground_of(single(tables["photo"], "photo")))


def in_mm(model: PhotoModel, xy: Array, system: System) -> Array:
    """(n, 2) readings in mm of the comparator."""
    if system == "image":
        return model.readings(xy)
    return model.mm_from_pixels(xy) if system == "px" else xy


def reading_covariance(model: PhotoModel, sigmas: Array | None, readings: Array, system: System) -> Array:
    """(n, 2, 2) [mm^2] of the readings; sigmas (n,) of corrected coordinates are taken back through the corrections."""
    if sigmas is None:
        own = np.full(len(readings), required(model.photo, "sigma_image_mm"))
    else:
        own = sigmas * (abs(model.pixel_step[0]) if system == "px" else 1.0)
    covariance = np.asarray(own[:, None, None] ** 2 * np.eye(2))
    if system != "image" or sigmas is None:
        return covariance
    back = np.linalg.inv(model.seen(readings).by_reading)
    return np.asarray(back @ covariance @ back.transpose(0, 2, 1))
