"""The operation from a coordinate reference system to the ground; apart from the ground, as it loads PROJ."""

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
from orient.pipeline.ground import Ground
from orient.pipeline.tables import Array

AREA_MARGIN_DEG = 0.01


def operation_to(
    ground: Ground, source_crs: str | None, coordinates: Array, source: str, allow_ballpark: bool
) -> tuple[CRS, CRS, Operation]:
    """Source CRS, target CRS and the operation to geographic coordinates of the ground that covers the points."""
    if source_crs is None:
        raise OrientError(
            f"{source} has projected coordinates but no CRS is stated",
            'State it: crs = "EPSG:..." in control.toml or sheet.toml.',
        )
    given = crs_from_text(source_crs)
    target = _target_for(ground, given)
    return given, target, find_operation(given, target, allow_ballpark, area=_area(given, coordinates))


def _target_for(ground: Ground, source: CRS) -> CRS:
    """The ground's CRS; a bare ellipsoid takes the datum of a source that stands on the same figure."""
    if ground.crs is not None:
        return crs_from_text(ground.crs)
    own, theirs = ground.figure, ground_ellipsoid(source)
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
