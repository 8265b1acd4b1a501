"""The coordinate system of the map layers, and the way of the project's points into it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pyproj import CRS
from pyproj.database import query_crs_info
from pyproj.enums import PJType

from orient.errors import OrientError, UsageError
from orient.export import Options
from orient.export.solved import Solved
from orient.geodesy.crs import (
    Area,
    Operation,
    crs_from_text,
    crs_kind,
    figure,
    find_operation,
    ground_ellipsoid,
    horizontal_part,
)
from orient.geodesy.ellipsoid import Ellipsoid
from orient.pipeline.tables import Array
from orient.units import DEGREES_PER_RADIAN

WGS84 = "EPSG:4326"
SMALLEST_EARTH_M, LARGEST_EARTH_M = 6.35e6, 6.4e6
AREA_MARGIN_DEG = 0.01


@dataclass(frozen=True, slots=True)
class MapSystem:
    """`text`: the system for GDAL, "" for local Cartesian metres; `notes` say what was taken for granted."""

    solved: Solved
    text: str
    name: str
    operation: Operation | None
    notes: Sequence[str]

    def of_stored(self, points: Array) -> Array:
        """(n, 2) map coordinates, x first, of points (n, 3) of the project's frame."""
        if self.operation is None:
            return self.solved.frame.right_handed(points)[:, :2]
        return self.of_geographic(self.solved.frame.geographic(points))

    def of_geographic(self, places: Array) -> Array:
        """(n, 2) map coordinates of B, L [rad], H."""
        if self.operation is None:
            raise ValueError("local Cartesian ground has no geographic coordinates")
        B, L, H = places.T
        x, y, _ = self.operation.transform(L * DEGREES_PER_RADIAN, B * DEGREES_PER_RADIAN, H)
        return np.column_stack([x, y])


def map_system(solved: Solved, options: Options) -> MapSystem:
    """The system asked for, else that of the project's map, else that of its ground."""
    if solved.frame.is_local:
        if options.crs:
            raise UsageError(
                "local Cartesian ground has no coordinate system: --crs cannot be used",
                "Leave --crs out: the layers get undefined Cartesian coordinates.",
            )
        return MapSystem(solved, "", "undefined Cartesian", None, ["The map has the project's local Cartesian metres."])
    ground, notes = ground_system(solved)
    target = crs_from_text(options.crs) if options.crs else _of_the_map(solved) or horizontal_part(ground)
    return _system(solved, ground, target, options, notes)


def wgs84_system(solved: Solved, options: Options) -> MapSystem:
    """WGS 84 longitude and latitude, the only system of GeoJSON (RFC 7946); refused where it cannot be reached."""
    hint = "Use gpkg, which takes any coordinate system."
    if options.crs:
        raise UsageError("GeoJSON is always in WGS 84 longitude and latitude (RFC 7946): --crs cannot be used", hint)
    if solved.frame.is_local:
        raise OrientError("GeoJSON is in WGS 84, and the ground of this photo is local Cartesian metres", hint)
    if not is_earth(solved.ground.figure):
        raise OrientError(
            f"GeoJSON is in WGS 84 on the Earth, and the ground of this photo is on {solved.ground.description}", hint
        )
    ground, notes = ground_system(solved)
    if solved.ground.crs is None and not ground.to_authority():
        message = f"GeoJSON is in WGS 84, and {solved.ground.description} has no datum from which WGS 84 can be reached"
        raise OrientError(message, f'State the datum in photo.toml, [ground] crs = "EPSG:...". {hint}')
    return _system(solved, ground, crs_from_text(WGS84), options, notes)


def is_earth(ellipsoid: Ellipsoid) -> bool:
    return SMALLEST_EARTH_M < ellipsoid.a_m < LARGEST_EARTH_M


def ground_system(solved: Solved) -> tuple[CRS, list[str]]:
    """The geographic system of B, L, H: as stated, that of the control, or the one that stands on the same figure."""
    ground = solved.ground
    if ground.crs is not None:
        return crs_from_text(ground.crs), []
    of_sources = {str(row["target_crs"]) for row in solved.current.tables.get("bl", {}).get("crs_operation", ())}
    if len(of_sources) == 1:
        found = crs_from_text(of_sources.pop())
        if found.to_authority() is not None:
            return found, [f"The ground's ellipsoid is taken with the datum of the control, {found.name}."]
    known = crs_from_text(WGS84)
    own, theirs = ground.figure, ground_ellipsoid(known)
    if (own.a_m, own.inverse_flattening) == (theirs.a_m, theirs.inverse_flattening):
        return known, ["The ground is the ellipsoid of WGS 84; its datum is taken as WGS 84."]
    if not own.inverse_flattening and not is_earth(own) and (found_body := _body(own)) is not None:
        return found_body, [f"The ground is a sphere of {own.a_m!r} m, taken as {found_body.name}."]
    return _unknown_datum(own), [f"The datum of the ground is not known: only its figure, {own.name}."]


def _body(sphere: Ellipsoid) -> CRS | None:
    """The planetocentric system of the IAU whose sphere this is; None if there is none, or more than one body."""
    infos = query_crs_info(auth_name="IAU_2015", pj_types=[PJType.GEOGRAPHIC_2D_CRS])
    fitting = []
    for info in infos:
        system = CRS.from_authority(info.auth_name, info.code)
        its = ground_ellipsoid(system)
        if its.a_m == sphere.a_m and not its.inverse_flattening:
            fitting.append(system)
    return fitting[0] if len(fitting) == 1 else None


def _unknown_datum(ellipsoid: Ellipsoid) -> CRS:
    """A geographic system named after its figure; GDAL would call that of a bare PROJ string `unknown`."""
    name = f"Unknown datum on the ellipsoid {ellipsoid.name}"
    parameters = CRS.from_user_input(f"+proj=longlat {figure(ellipsoid)} +type=crs").to_json_dict()
    parameters["name"] = name
    parameters["datum"]["name"] = name
    parameters["datum"]["ellipsoid"]["name"] = ellipsoid.name
    return CRS.from_json_dict(parameters)


def _of_the_map(solved: Solved) -> CRS | None:
    """The projected system in which all control came, if it was one."""
    rows = solved.current.tables.get("bl", {}).get("crs_operation", ())
    systems = {str(row["source_crs"]) for row in rows}
    if len(systems) != 1:
        return None
    found = horizontal_part(crs_from_text(systems.pop()))
    return found if crs_kind(found) == "projected" else None


def _system(solved: Solved, ground: CRS, target: CRS, options: Options, notes: list[str]) -> MapSystem:
    horizontal = horizontal_part(target)
    if crs_kind(horizontal) not in ("geographic", "projected"):
        raise UsageError(
            f'"{target.name}" is not a system of maps', "Give a geographic or projected system, such as EPSG:4326."
        )
    operation = find_operation(ground, horizontal, options.allow_ballpark, _area(solved))
    if operation.definition != "noop":
        known = "of unknown accuracy" if operation.accuracy_m is None else f"accurate to {operation.accuracy_m:g} m"
        notes = [*notes, f"From {ground.name} by {operation.name} ({known})."]
    flat = horizontal.to_2d()
    authority = flat.to_authority(min_confidence=100)
    text = ":".join(authority) if authority else flat.to_wkt()
    return MapSystem(solved, text, flat.name, operation, notes)


def _area(solved: Solved) -> Area:
    """West, south, east, north of the points [deg]."""
    rows = solved.current.tables["topocentric"]["topocentric_point"]
    stored = np.array([[row["X_m"], row["Y_m"], row["Z_m"]] for row in rows], dtype=np.float64)
    B, L = solved.frame.geographic(stored)[:, :2].T * DEGREES_PER_RADIAN
    west, east = float(L.min()) - AREA_MARGIN_DEG, float(L.max()) + AREA_MARGIN_DEG
    return west, max(float(B.min()) - AREA_MARGIN_DEG, -90.0), east, min(float(B.max()) + AREA_MARGIN_DEG, 90.0)
