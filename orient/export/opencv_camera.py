"""The camera of the photo as K and the distortion coefficients of OpenCV, exactly or fitted, or free of distortion."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from orient.errors import GeometryError
from orient.export.pixels import PixelGrid
from orient.export.solved import Solved, SolvedPoints
from orient.geometry.camera import Camera, Measured, corrected
from orient.geometry.frame_centre import frame_centre
from orient.geometry.opencv_lens import NAMES, OpencvLens, converted, distorted, fitted
from orient.geometry.vertical_photo import grid_layout
from orient.pipeline.image_corrections import air_and_curvature
from orient.pipeline.tables import Array, required
from orient.values import Row

SIDE = 41
LARGEST_MISFIT_PX = 0.005
"""Half of a hundredth of a pixel: what a fitted lens may miss anywhere in the frame."""
MARGIN = 1.02


@dataclass(frozen=True, slots=True)
class OpencvCamera:
    """K (3, 3) [px], distortion coefficients (12,) in OpenCV's order; how they were found, and how far they hold.

    `method`: exact | fitted | undistorted; `misfit_px`: largest difference to the photo's own lens, None if exact.
    `image_points` (n, 2) [px]: what goes with K and the coefficients.
    """

    K: Array
    coefficients: Array
    method: str
    misfit_px: float | None
    told: str
    image_points: Array


def opencv_camera(solved: Solved, points: SolvedPoints, grid: PixelGrid) -> OpencvCamera:
    """Exact where the lens goes from ideal to distorted positions, else fitted over the frame, else without a lens."""
    measured = grid.of(points.frame_xy)
    lens = _exact(solved, grid)
    if lens is not None:
        told = "the photo's lens in OpenCV's terms"
        return OpencvCamera(_K(solved, grid, lens, True), lens.coefficients, "exact", None, told, measured)
    smallest, reason = np.inf, "the photo's lens has no way back over its frame"
    for where, samples in _regions(solved, points):
        ideal = _ideal(solved, samples)
        if ideal is None:
            continue
        lens, misfit = _fitted(solved, grid, samples, ideal)
        smallest = min(smallest, misfit)
        if misfit <= LARGEST_MISFIT_PX:
            told = f"the photo's lens{_with_air(solved.photo)} fitted over {where}; outside of it the fit does not hold"
            return OpencvCamera(_K(solved, grid, lens, False), lens.coefficients, "fitted", misfit, told, measured)
        reason = f"OpenCV's lens misses the photo's by up to {smallest:.2g} px"
    none = OpencvLens(np.zeros(len(NAMES)))
    told = f"{reason}: image_points are corrected for distortion instead, and the coefficients are zero"
    corrected_xy = grid.of(points.image + solved.camera.principal_point)
    return OpencvCamera(_K(solved, grid, none, False), none.coefficients, "undistorted", None, told, corrected_xy)


def _exact(solved: Solved, grid: PixelGrid) -> OpencvLens | None:
    """None where refraction, curvature or a skew stands between the lens and the reading."""
    photo, camera = solved.photo, solved.camera
    is_clear = photo["refraction"] == "none" and photo["curvature_radius_m"] is None
    is_affine = camera.b1 != 0.0 or camera.b2 != 0.0
    if not is_clear or camera.b2 != 0.0 or (is_affine and not _takes_affinity(camera)):
        return None
    return converted(camera.distortion, camera.f_mm, grid.axes)


def _takes_affinity(camera: Camera) -> bool:
    """b1 stretches what was measured: a second focal length, where the lens leads to the measured side."""
    return camera.is_from_ideal


def _K(solved: Solved, grid: PixelGrid, lens: OpencvLens, with_affinity: bool) -> Array:
    f = solved.camera.f_mm * lens.scale / grid.size_mm
    column, row = grid.of(solved.camera.principal_point[None, :])[0]
    stretch = 1.0 + solved.camera.b1 if with_affinity else 1.0
    return np.array([[f * stretch, 0.0, column], [0.0, f, row], [0.0, 0.0, 1.0]])


def _with_air(photo: Row) -> str:
    parts = [] if photo["refraction"] == "none" else ["refraction"]
    parts += [] if photo["curvature_radius_m"] is None else ["earth curvature"]
    return f" with {' and '.join(parts)}" if parts else ""


def _regions(solved: Solved, points: SolvedPoints) -> Iterator[tuple[str, Array]]:
    """Places (n, 2) [mm] over the frame, then over the part of it that holds the points."""
    photo = solved.photo
    size = (required(photo, "frame_width_mm"), required(photo, "frame_height_mm"))
    yield "the whole frame", grid_layout(*size, SIDE, SIDE) + np.array(frame_centre(photo))
    low, high = points.frame_xy.min(axis=0), points.frame_xy.max(axis=0)
    width, height = (MARGIN * (high - low)).tolist()
    yield "the part of the frame that holds the points", grid_layout(width, height, SIDE, SIDE) + (low + high) / 2


def _ideal(solved: Solved, samples: Array) -> Array | None:
    """(n, 2) [mm] positions by collinearity of measured ones; None where the lens has no way back."""
    nothing = np.zeros_like(samples)
    try:
        clear = corrected(solved.camera, Measured(samples, nothing))
        air, curvature = air_and_curvature(clear, solved.photo)
        return corrected(solved.camera, Measured(samples, air + curvature))
    except GeometryError:
        return None


def _fitted(solved: Solved, grid: PixelGrid, samples: Array, ideal: Array) -> tuple[OpencvLens, float]:
    """The lens, and the largest difference [px] at the samples; with a denominator only where it is needed."""
    f = solved.camera.f_mm
    along, wanted = ideal * grid.axes / f, (samples - solved.camera.principal_point) * grid.axes / f
    for rational in (False, True):
        lens = fitted(along, wanted, rational=rational)
        missed = np.linalg.norm(distorted(lens, along) - wanted, axis=1)
        misfit = float(np.max(missed)) * f / grid.size_mm
        if misfit <= LARGEST_MISFIT_PX:
            break
    return lens, misfit
