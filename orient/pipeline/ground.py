"""The ground of a photo as the stages see it: ellipsoid, datum, or local Cartesian metres."""

from dataclasses import dataclass

import numpy as np
from pyproj import CRS

from orient.errors import OrientError
from orient.geodesy.crs import (
    Operation,
    crs_from_text,
    find_operation,
    geographic_crs,
    geographic_crs_of,
    ground_ellipsoid,
)
from orient.geodesy.ellipsoid import Ellipsoid
from orient.geodesy.topocentric import geographic_from_geocentric
from orient.pipeline.tables import Array, number, required
from orient.units import DEGREES_PER_RADIAN, RADIANS_PER_DEGREE
from orient.values import Row

AREA_MARGIN_DEG = 0.01


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

    def operation_from(
        self, source_crs: str | None, coordinates: Array, source: str, allow_ballpark: bool
    ) -> tuple[CRS, CRS, Operation]:
        """Source CRS, target CRS and the operation to geographic coordinates of the ground that covers the points."""
        if source_crs is None:
            raise OrientError(
                f"{source} has projected coordinates but no CRS is stated",
                'State it: crs = "EPSG:..." in control.toml or sheet.toml.',
            )
        given = crs_from_text(source_crs)
        target = self._target_for(given)
        return given, target, find_operation(given, target, allow_ballpark, area=_area(given, coordinates))

    def _target_for(self, source: CRS) -> CRS:
        """The ground's CRS; a bare ellipsoid takes the datum of a source that stands on the same figure."""
        if self.crs is not None:
            return crs_from_text(self.crs)
        own, theirs = self.figure, ground_ellipsoid(source)
        if (own.a_m, own.inverse_flattening) == (theirs.a_m, theirs.inverse_flattening) and source.geodetic_crs:
            return source.geodetic_crs
        return geographic_crs_of(own)


def _area(crs: CRS, coordinates: Array) -> tuple[float, float, float, float] | None:
    """West, south, east, north [deg] of the points: PROJ chooses the operation made for them."""
    whole = coordinates[~np.isnan(coordinates[:, :2]).any(axis=1)]
    if not len(whole):
        return None
    longitude, latitude, _ = find_operation(crs, geographic_crs(crs)).transform(*np.nan_to_num(whole).T)
    return (
        float(np.min(longitude)) - AREA_MARGIN_DEG,
        max(float(np.min(latitude)) - AREA_MARGIN_DEG, -90.0),
        float(np.max(longitude)) + AREA_MARGIN_DEG,
        min(float(np.max(latitude)) + AREA_MARGIN_DEG, 90.0),
    )


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
