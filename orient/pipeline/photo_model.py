"""The oriented photo as a map between readings, corrected image coordinates and the ground, for any points.

A reading q goes the way of the stages: interior orientation, principal point, lens, refraction, curvature, and then
through what the resection adjusted of camera and interior orientation. The way back is solved for by Newton's method.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from orient.errors import GeometryError
from orient.geometry import plane
from orient.geometry.camera import Measured
from orient.geometry.collinearity import project
from orient.geometry.frame_centre import frame_centre
from orient.pipeline.frames import Frame, frame_of
from orient.pipeline.ground import ground_of
from orient.pipeline.ground_budget import SeenImage
from orient.pipeline.image_corrections import image_corrections
from orient.pipeline.oriented import Oriented, oriented_by
from orient.pipeline.refine import frame_coordinates, pixel_grid
from orient.pipeline.tables import Array, required, single
from orient.values import Row, Tables

STAGES = ("photo", "readings", "refine", "topocentric", "resection")
"""The stages whose tables a model is made from."""
STEP_MM = 1e-3
CLOSED_MM = 1e-10
MOST_STEPS = 20
FRAME_MARGIN = 0.1
"""Share of the frame by which a point may lie outside of it and still have an image."""


@dataclass(frozen=True, slots=True)
class Seen:
    """Readings through the whole chain: corrected coordinates, and what they depend on.

    `image` (n, 2) [mm], `by_reading` (n, 2, 2) its partials by the reading [mm], `through`: by the unknowns.
    """

    image: Array
    by_reading: Array
    through: SeenImage


@dataclass(frozen=True, slots=True)
class PhotoModel:
    """One photo with its current orientation. `interior`: name and parameters of the fiducial transformation.

    `in_pixels`: are the readings of the project columns and rows?
    """

    photo: Row
    photo_tables: Tables
    frame: Frame
    oriented: Oriented
    interior: tuple[str, Array] | None
    in_pixels: bool

    def seen(self, readings: Array) -> Seen:
        """Corrected image coordinates of readings (n, 2) [mm of the comparator]."""
        in_frame, by_reading = frame_coordinates(readings, self.interior)
        reduced = in_frame - self.principal_point
        names = [str(i) for i in range(len(readings))]
        lens, refraction, curvature = image_corrections(self.photo, self.photo_tables, reduced, names)
        air = refraction + curvature
        through = self.oriented.rays.seen(reduced + lens + air, readings, Measured(in_frame, air))
        return Seen(through.image, np.asarray(through.by_reading @ by_reading), through)

    def readings(self, image: Array) -> Array:
        """(n, 2) readings [mm of the comparator] whose corrected coordinates are `image` (n, 2) [mm]."""
        guess = image + self.principal_point
        q = guess if self.interior is None else plane.invert(*self.interior, guess)
        for _ in range(MOST_STEPS):
            gap = image - self.seen(q).image
            q = q + np.linalg.solve(self._slope(q), gap[:, :, None])[:, :, 0]
            if np.max(np.abs(gap), initial=0.0) <= CLOSED_MM:
                return q
        worst = int(np.argmax(np.max(np.abs(gap), axis=1)))
        raise GeometryError(
            f"no reading belongs to the image point {image[worst, 0]:.3f}, {image[worst, 1]:.3f} mm: "
            "the corrections of lens and air have no inverse there",
            "Ask for points within the frame only.",
        )

    def project(self, ground: Array) -> tuple[Array, Array]:
        """Corrected image coordinates (n, 2) [mm] of right-handed ground (n, 3), and which points (n,) are seen.

        Seen: in front of the camera and not outside the frame by more than a tenth of it.
        """
        oriented = self.oriented
        image, zs = project(ground, oriented.station, oriented.rotation, oriented.f_mm)
        size = np.array([required(self.photo, "frame_width_mm"), required(self.photo, "frame_height_mm")])
        from_centre = image + self.principal_point - np.array(frame_centre(self.photo))
        with np.errstate(invalid="ignore"):
            inside = np.all(np.abs(from_centre) <= (0.5 + FRAME_MARGIN) * size, axis=1)
        return image, np.asarray((zs < 0) & inside)

    @property
    def principal_point(self) -> Array:
        """(2,) [mm] of photo.toml."""
        return np.array([required(self.photo, "x0_mm"), required(self.photo, "y0_mm")])

    def mm_from_pixels(self, pixels: Array) -> Array:
        """(n, 2) mm from columns and rows."""
        origin, step = pixel_grid(self.photo)
        return np.asarray((pixels - origin) * step)

    def pixels_from_mm(self, mm: Array) -> Array:
        """(n, 2) columns and rows from mm."""
        origin, step = pixel_grid(self.photo)
        return np.asarray(origin + mm / step)

    @property
    def pixel_step(self) -> Array:
        """(2,) mm that x and y grow by for one column and one row."""
        return pixel_grid(self.photo)[1]

    def _slope(self, readings: Array) -> Array:
        """(n, 2, 2) d image/d reading by central differences: it holds the slopes of lens and air too."""
        steps = STEP_MM * np.eye(2)
        differences = [self.seen(readings + step).image - self.seen(readings - step).image for step in steps]
        return np.stack(differences, axis=-1) / (2 * STEP_MM)


def photo_model(tables: Mapping[str, Tables]) -> PhotoModel:
    """The model from the tables of `STAGES`."""
    photo = single(tables["photo"], "photo")
    frame = frame_of(single(tables["topocentric"], "topocentric_frame"), ground_of(photo))
    readings = tables["readings"]["comparator_reading"]
    return PhotoModel(
        photo=photo,
        photo_tables=tables["photo"],
        frame=frame,
        oriented=oriented_by(tables["photo"], tables["refine"], tables["resection"], frame),
        interior=_interior(tables["refine"]),
        in_pixels=any(row["col_px"] is not None for row in readings),
    )


def _interior(refine: Tables) -> tuple[str, Array] | None:
    rows = refine.get("interior_orientation", ())
    if not rows:
        return None
    name = str(rows[0]["transformation"])
    by_name = {str(row["name"]): required(row, "value") for row in refine["interior_parameter"]}
    return name, np.array([by_name[parameter] for parameter in plane.parameter_names(name)])
