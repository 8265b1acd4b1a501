"""Points that are both measured on the photo and placed on the ground: what a resection is computed from."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from orient.pipeline.frames import Frame
from orient.pipeline.tables import Array, columns, names, rows_at
from orient.units import listed
from orient.values import Event, Row, Tables
from orient.words import counted

NO_CONTROL = (
    "point is measured on the photo but has no ground coordinates, not used",
    "points are measured on the photo but have no ground coordinates, not used",
)
NOT_MEASURED = (
    "point has ground coordinates but is not measured on the photo, not used",
    "points have ground coordinates but are not measured on the photo, not used",
)


@dataclass(frozen=True, slots=True)
class Observations:
    """Points that are both measured on the photo and placed on the ground, in the frame of T'.

    `comparator` (n, 2) [mm]: before the interior orientation.
    """

    points: Sequence[str]
    roles: Sequence[str]
    image: Array
    image_covariance: Array
    comparator: Array
    rows: Sequence[Row]
    image_rows: Sequence[Row] = ()

    def only(self, role: str) -> "Observations":
        return self.at([index for index, value in enumerate(self.roles) if value == role])

    def at(self, keep: Sequence[int]) -> "Observations":
        """The points at these places of the list."""
        return Observations(
            [self.points[index] for index in keep],
            [self.roles[index] for index in keep],
            self.image[keep],
            self.image_covariance[keep],
            self.comparator[keep],
            rows_at(self.rows, keep),
            rows_at(self.image_rows, keep) if self.image_rows else (),
        )

    @property
    def ground(self) -> Array:
        return columns(self.rows, "X_m", "Y_m", "Z_m")

    @property
    def up(self) -> Array:
        return columns(self.rows, "up_X", "up_Y", "up_Z")

    @property
    def known(self) -> Array:
        return np.array(names(self.rows, "known"))


def observations(refine: Tables, topocentric: Tables) -> tuple[Observations, list[Event]]:
    """Pairs readings with ground points by name, and says what found no partner."""
    image = {point: place for place, point in enumerate(names(refine["image_point"]))}
    ground = {point: place for place, point in enumerate(names(topocentric["topocentric_point"]))}
    both = [point for point in image if point in ground]
    events = [
        *_unused(image, ground, "no_control", *NO_CONTROL),
        *_unused(ground, image, "not_measured", *NOT_MEASURED),
    ]
    rows = rows_at(refine["image_point"], [image[point] for point in both])
    ground_rows = rows_at(topocentric["topocentric_point"], [ground[point] for point in both])
    packed = columns(rows, "cov_xx_mm2", "cov_xy_mm2", "cov_xy_mm2", "cov_yy_mm2")
    seen = Observations(
        points=both,
        roles=names(ground_rows, "role"),
        image=columns(rows, "x_mm", "y_mm"),
        image_covariance=packed.reshape(-1, 2, 2),
        comparator=columns(rows, "x_comparator_mm", "y_comparator_mm"),
        rows=ground_rows,
        image_rows=rows,
    )
    return seen, events


def _unused(here: Collection[str], there: Collection[str], code: str, one: str, many: str) -> list[Event]:
    """One event for all points that have no partner."""
    alone = [point for point in here if point not in there]
    if not alone:
        return []
    told = listed(alone)
    return [Event("warning", code, told, f"{counted(len(alone), one, many)}: {told}", float(len(alone)))]


def on_their_height(control: Observations, place: Array, adjusted: Array, frame: Frame) -> tuple[Array, Array]:
    """Places and verticals (n, 3): height-only points on the curved surface of their height, over `adjusted`.

    `place` (n, 3): where they stand now, at their given height; `adjusted` (n, 3): where the resection wants them; all
    in the stored frame. Other points, and those of a local frame, stay.
    """
    moved, up = place.copy(), control.up.copy()
    index = np.flatnonzero(control.known == "height")
    if len(index) and frame.origin is not None:
        height = frame.geographic(place[index])[:, 2]
        latitude, longitude, _ = frame.geographic(adjusted[index]).T
        moved[index] = frame.from_geographic(latitude, longitude, height)
        up[index] = frame.from_geographic(latitude, longitude, height + 1.0) - moved[index]
    return moved, up
