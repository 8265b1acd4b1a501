"""col = col0 + s_x x/p, row = row0 + s_y y/p: the pixels of an export, x and y [mm] of the frame.

The photo's own pixels where its readings are pixels of one image; else those of a virtual scan of the frame: the
readings of a film go through its fiducial marks first, and no K of a camera can hold that transformation.
"""

from dataclasses import dataclass

import numpy as np

from orient.errors import UsageError
from orient.geometry.frame_centre import frame_centre
from orient.pipeline.tables import Array, number, required
from orient.values import Row

VIRTUAL_PIXEL_MM = 0.01


@dataclass(frozen=True, slots=True)
class PixelGrid:
    """Pixels of `size_mm`; the centre of the first one is (0, 0), columns run right and rows down in the image.

    `axes` (2,): s_x, s_y, the directions of columns and rows along x and y; `origin` (2,): column and row of x = y = 0;
    `width`, `height`: of the image in pixels. `is_real`: pixels of the photo's own image.
    """

    size_mm: float
    axes: Array
    origin: Array
    width: int
    height: int
    is_real: bool

    def of(self, xy: Array) -> Array:
        """(n, 2) columns and rows of places (n, 2) of the frame [mm]."""
        return np.asarray(self.origin + self.axes * xy / self.size_mm)

    @property
    def in_words(self) -> str:
        if self.is_real:
            return f"pixel of the image, {self.size_mm:g} mm; the centre of the first one is (0, 0)"
        return (
            f"virtual pixel of {self.size_mm:g} mm: the frame through its fiducial marks or in comparator millimetres, "
            "columns to the right, rows downwards; the centre of the first one is (0, 0)"
        )


def pixel_grid(photo: Row, asked_mm: float | None) -> PixelGrid:
    """The photo's own pixels, or virtual ones of `asked_mm` (default: the scan's size, else 0.01 mm)."""
    size, is_scan = number(photo, "pixel_size_mm"), photo["interior_transformation"] == "none"
    axes = np.array([1.0 if photo["x_axis"] == "right" else -1.0, -1.0 if photo["y_axis"] == "up" else 1.0])
    if size is not None and is_scan and axes.prod() < 0:
        if asked_mm is not None and asked_mm != size:
            raise UsageError(
                f"the pixels of this photo are {size:g} mm, not {asked_mm:g} mm", "Leave --pixel-mm out for this photo."
            )
        return _own(photo, size, axes)
    return _virtual(photo, asked_mm or size or VIRTUAL_PIXEL_MM)


def _own(photo: Row, size: float, axes: Array) -> PixelGrid:
    origin = np.array([number(photo, "origin_col_px") or 0.0, number(photo, "origin_row_px") or 0.0])
    frame = [required(photo, "frame_width_mm") / size, required(photo, "frame_height_mm") / size]
    width, height = (number(photo, name) for name in ("image_width_px", "image_height_px"))
    return PixelGrid(size, axes, origin, round(width or frame[0]), round(height or frame[1]), is_real=True)


def _virtual(photo: Row, size: float) -> PixelGrid:
    """Columns and rows from the upper left corner of the frame."""
    frame = np.array([required(photo, "frame_width_mm"), required(photo, "frame_height_mm")])
    corner = np.array(frame_centre(photo)) + frame / 2 * [-1.0, 1.0]
    axes = np.array([1.0, -1.0])
    width, height = np.ceil(frame / size - 1e-9).astype(int).tolist()
    return PixelGrid(size, axes, -axes * corner / size - 0.5, width, height, is_real=False)
