"""The ground of a photo as the stages see it: ellipsoid, datum, or local Cartesian metres."""

from dataclasses import dataclass

import numpy as np

from orient.errors import OrientError
from orient.geodesy.ellipsoid import Ellipsoid, meridian_radius, prime_vertical_radius
from orient.geodesy.topocentric import geographic_from_geocentric
from orient.pipeline.tables import Array, number, required
from orient.units import DEGREES_PER_RADIAN, RADIANS_PER_DEGREE
from orient.values import Row


@dataclass(frozen=True, slots=True)
class Ground:
    """`kind` is crs, ellipsoid or local; `ellipsoid` is None only for local ground."""

    kind: str
    crs: str | None
    ellipsoid: Ellipsoid | None
    handedness: str | None
    central_meridian: float | None
    mean_height: float

    @property
    def is_local(self) -> bool:
        return self.kind == "local"

    @property
    def description(self) -> str:
        if self.is_local:
            return f"local Cartesian ({self.handedness}-handed)"
        return self.crs or f"the ellipsoid {self.figure.name}"

    @property
    def figure(self) -> Ellipsoid:
        if self.ellipsoid is None:
            raise OrientError("local Cartesian ground has no ellipsoid", "Give [ground] crs or ellipsoid.")
        return self.ellipsoid

    def geographic_from_geocentric(self, xyz: Array) -> Array:
        """(n, 3) L, B [deg], H from geocentric X, Y, Z on the ground's own ellipsoid."""
        latitude, longitude, height = geographic_from_geocentric(xyz, self.figure).T
        return np.column_stack([longitude * DEGREES_PER_RADIAN, latitude * DEGREES_PER_RADIAN, height])


def ground_of(photo: Row) -> Ground:
    """The ground that the photo's row describes."""
    kind = str(photo["ground_kind"])
    meridian = number(photo, "central_meridian_deg")
    ellipsoid = None
    if kind != "local":
        axis, flattening = required(photo, "a_m"), required(photo, "inverse_flattening")
        ellipsoid = Ellipsoid(str(photo["ellipsoid"] or "ellipsoid"), axis, flattening)
    return Ground(
        kind=kind,
        crs=None if photo["ground_crs"] is None else str(photo["ground_crs"]),
        ellipsoid=ellipsoid,
        handedness=None if photo["handedness"] is None else str(photo["handedness"]),
        central_meridian=None if meridian is None else meridian * RADIANS_PER_DEGREE,
        mean_height=number(photo, "ground_height_m") or 0.0,
    )


def metres_per_unit(target: Array, is_geographic: bool, ground: Ground) -> Array:
    """(n, 2) metres northwards and eastwards per unit of the target: M rho and N cos B rho, or 1 on a grid."""
    if not is_geographic:
        return np.ones_like(target)
    latitude = target[:, 0] * RADIANS_PER_DEGREE
    north = meridian_radius(ground.figure, latitude)
    east = prime_vertical_radius(ground.figure, latitude) * np.cos(latitude)
    return np.column_stack([north, east]) * RADIANS_PER_DEGREE
