"""Stage `bl`: B, L, H of all points on the ground's ellipsoid, with covariance in each point's own horizon.

Local Cartesian points pass through. A datum change is PROJ's, and the exact operation is recorded.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from orient.errors import OrientError
from orient.geodesy.ellipsoid import meridian_radius, prime_vertical_radius
from orient.geodesy.topocentric import local_axes
from orient.pipeline.ground import Ground, ground_of
from orient.pipeline.tables import Array, columns, covariance_columns, covariances, names, or_none, single
from orient.units import DEGREES_PER_RADIAN, RADIANS_PER_DEGREE
from orient.values import Event, Outcome, Row, Settings, Tables
from orient.words import counted

if TYPE_CHECKING:
    from orient.geodesy.crs import Operation

STEP_M = 1.0
LOCAL_KINDS = ("local",)


@dataclass(frozen=True, slots=True)
class SourcePoints:
    """Points of one source in its own system: `coordinates` (n, 3) in the axis order E/L, N/B, H or X, Y, Z.

    Degrees for geographic ones; NaN = not given. `covariance` (n, 3, 3) has the axes north, east, up (X, Y, Z for
    geocentric and local points), NaN = taken as known. `is_sheet`: points of a digitised map sheet.
    """

    source: str
    kind: str
    crs: str | None
    names: Sequence[str]
    coordinates: Array
    covariance: Array
    is_sheet: bool = False


def compute(inputs: Mapping[str, Tables], settings: Settings) -> Outcome:
    """Outcome with `geographic_point` and `crs_operation` rows."""
    ground = ground_of(single(inputs["photo"], "photo"))
    control = inputs.get("control", {})
    roles = {str(row["point"]): str(row["role"]) for row in control.get("control_point", ())}
    sources = [*_control_sources(control, ground), *_sheet_sources(inputs.get("digitize", {}))]
    rows: list[dict[str, object]] = []
    operations: list[Row] = []
    events: list[Event] = []
    for source in sources:
        if source.kind in LOCAL_KINDS or ground.is_local:
            rows += _passed_through(source, ground, roles)
            events.append(_passed_event(source))
        else:
            geographic, grid_north, operation = _to_ground(source, ground, bool(settings["allow_ballpark"]))
            in_horizon = _in_horizon(source, geographic, grid_north, ground)
            north = grid_north if source.is_sheet else np.full_like(grid_north, np.nan)
            rows += _geographic_rows(source, geographic, in_horizon, north, roles)
            operations += operation
            events += [_ballpark_event(source) for row in operation if row["is_ballpark"]]
    merged = _merge(rows, events)
    events += _unplaced(roles, merged)
    if not merged:
        raise OrientError("no point has coordinates", "Give coordinates in control.csv or digitise points on a sheet.")
    checks = sum(row["role"] == "check" for row in merged)
    summary = f"{counted(len(merged), 'point')}, {checks} of them {'a check point' if checks == 1 else 'check points'}"
    return Outcome({"geographic_point": merged, "crs_operation": operations}, events, summary)  # type: ignore[dict-item]


def _control_sources(control: Tables, ground: Ground) -> list[SourcePoints]:
    rows = control.get("control_point", ())
    if not rows:
        return []
    crs = single(control, "control_system")["crs"]
    sources = []
    for kind, fields in COORDINATE_FIELDS.items():
        chosen = [row for row in rows if row["kind"] == kind]
        if chosen:
            text = None if crs is None else str(crs)
            sources.append(
                SourcePoints("control", kind, text, names(chosen), columns(chosen, *fields), covariances(chosen))
            )
    return sources


COORDINATE_FIELDS = {
    "geographic": ("L_deg", "B_deg", "H_m"),
    "projected": ("E_m", "N_m", "H_m"),
    "geocentric": ("X_m", "Y_m", "Z_m"),
    "local": ("X_m", "Y_m", "Z_m"),
}


def _sheet_sources(digitize: Tables) -> list[SourcePoints]:
    transforms = {str(row["sheet"]): row for row in digitize.get("sheet_transform", ())}
    sources = []
    for sheet, transform in transforms.items():
        rows = [row for row in digitize.get("digitized_point", ()) if row["sheet"] == sheet]
        if not rows:
            continue
        kind = "geographic" if transform["target"] == "geographic" else "projected"
        crs = None if transform["crs"] is None else str(transform["crs"])
        coordinates = columns(rows, *COORDINATE_FIELDS[kind])
        covariance = _sheet_covariance(rows)
        sources.append(SourcePoints(sheet, kind, crs, names(rows), coordinates, covariance, is_sheet=True))
    return sources


def _sheet_covariance(rows: Sequence[Row]) -> Array:
    plan = columns(rows, "cov_NN_m2", "cov_NE_m2", "cov_EE_m2")
    sigma_height = np.nan_to_num(columns(rows, "sigma_H_m")[:, 0])
    covariance = np.zeros((len(rows), 3, 3))
    covariance[:, 0, 0], covariance[:, 0, 1], covariance[:, 1, 0], covariance[:, 1, 1] = plan[:, [0, 1, 1, 2]].T
    covariance[:, 2, 2] = sigma_height**2
    return covariance


def _passed_through(source: SourcePoints, ground: Ground, roles: Mapping[str, str]) -> list[dict[str, object]]:
    if not (source.kind in LOCAL_KINDS and ground.is_local):
        raise OrientError(
            f"{source.source} has {source.kind} coordinates, but the photo's ground is {ground.description}",
            "Give both as local Cartesian metres, or both on an ellipsoid.",
        )
    rows: list[dict[str, object]] = []
    for name, xyz, covariance in zip(source.names, source.coordinates, source.covariance, strict=True):
        local = {"X_m": or_none(xyz[0]), "Y_m": or_none(xyz[1]), "Z_m": or_none(xyz[2])}
        empty = {"B_deg": None, "L_deg": None, "H_m": None, "sheet_north_deg": None}
        rows.append({**_head(name, source, roles, covariance), **empty, **local, **_covariance(covariance)})
    return rows


def _passed_event(source: SourcePoints) -> Event:
    many = counted(len(source.names), "point is", "points are")
    message = f"{many} local Cartesian: passed through without a change"
    return Event("info", "passed_through", source.source, message)


def _ballpark_event(source: SourcePoints) -> Event:
    message = f"{source.source}: the datum change is a ballpark one, as allowed: it may be off by hundreds of metres"
    return Event("warning", "ballpark", source.source, message)


def _to_ground(source: SourcePoints, ground: Ground, allow_ballpark: bool) -> tuple[Array, Array, list[Row]]:
    """(n, 3) L, B [deg], H on the ground, (n,) azimuth of grid north [rad], the operation's row.

    Heights that are not given stay NaN; a plan position is then transformed at the mean height of the ground.
    """
    north = np.zeros(len(source.names))
    if source.kind == "geocentric" and source.crs is None:
        return ground.geographic_from_geocentric(source.coordinates), north, []
    if source.kind == "geographic" and source.crs is None:
        return source.coordinates, north, []
    from orient.pipeline.ground_crs import operation_to

    given, target, operation = operation_to(ground, source.crs, source.coordinates, source.source, allow_ballpark)
    transformed = _transform(source, ground, operation)
    if source.kind == "projected":
        north = _grid_north(source, ground, operation, transformed)
    row = {
        "source": source.source,
        "source_crs": given.to_string(),
        "target_crs": target.to_string(),
        "name": operation.name,
        "definition": operation.definition,
        "accuracy_m": or_none(operation.accuracy_m),
        "grids": " ".join([*operation.grids, *(f"missing:{grid}" for grid in operation.missing_grids)]),
        "is_ballpark": int(operation.is_ballpark),
        "proj_version": operation.proj_version,
    }
    return transformed, north, [row]


def _transform(source: SourcePoints, ground: Ground, operation: "Operation") -> Array:
    """Geographic coordinates; a height without plan is changed as at the middle of the other points."""
    no_plan, no_height = np.isnan(source.coordinates[:, 0]), np.isnan(source.coordinates[:, 2])
    if no_plan.all():
        raise OrientError(
            f"{source.source} has heights only, so their change from {source.crs} to the ground is not known",
            "Give the heights on the ground's own ellipsoid, or at least one point with its plan position.",
        )
    given = source.coordinates.copy()
    given[no_plan, :2] = np.nanmean(given[:, :2], axis=0)
    given[no_height, 2] = ground.mean_height
    transformed = np.column_stack(operation.transform(*given.T))
    outside = ~np.isfinite(transformed).all(axis=1)
    if outside.any():
        point = source.names[int(np.argmax(outside))]
        raise OrientError(
            f'point "{point}" of {source.source} lies outside the area of "{operation.name}"',
            "Check the coordinates and the CRS.",
        )
    transformed[no_height, 2] = np.nan
    transformed[no_plan, :2] = np.nan
    return transformed


def _grid_north(source: SourcePoints, ground: Ground, operation: "Operation", geographic: Array) -> Array:
    """(n,) azimuth of the grid's north [rad], from a step along it."""
    moved = source.coordinates + np.array([0.0, STEP_M, 0.0])
    moved[:, 2] = np.where(np.isnan(moved[:, 2]), ground.mean_height, moved[:, 2])
    moved = np.where(np.isnan(moved), 0.0, moved)
    longitude, latitude, _ = operation.transform(*moved.T)
    d_longitude = np.remainder(longitude - geographic[:, 0] + 180.0, 360.0) - 180.0
    mean = geographic[:, 1] * RADIANS_PER_DEGREE
    east = d_longitude * prime_vertical_radius(ground.figure, mean) * np.cos(mean)
    north = (latitude - geographic[:, 1]) * meridian_radius(ground.figure, mean)
    return np.nan_to_num(np.arctan2(east, north))


def _in_horizon(source: SourcePoints, geographic: Array, grid_north: Array, ground: Ground) -> Array:
    """(n, 3, 3) covariances with the axes north, east, up of each point."""
    if source.kind == "geocentric":
        longitude, latitude = geographic[:, 0] * RADIANS_PER_DEGREE, geographic[:, 1] * RADIANS_PER_DEGREE
        turn = local_axes(latitude, longitude).transpose(0, 2, 1)
    else:
        cosine, sine, zero = np.cos(grid_north), np.sin(grid_north), np.zeros_like(grid_north)
        turn = np.stack([cosine, -sine, zero, sine, cosine, zero, zero, zero, zero + 1.0], axis=-1).reshape(-1, 3, 3)
    # an axis that is not given has no variance: it must not blot out the others when the axes are turned
    is_given = np.asarray(np.isfinite(source.covariance).any(axis=(1, 2)))
    covariance = np.where(is_given[:, None, None], np.nan_to_num(source.covariance), np.nan)
    turned: Array = turn @ covariance @ turn.transpose(0, 2, 1)
    return turned


def _geographic_rows(
    source: SourcePoints, geographic: Array, covariances: Array, sheet_north: Array, roles: Mapping[str, str]
) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = []
    degrees = sheet_north * DEGREES_PER_RADIAN
    places = zip(source.names, geographic, covariances, degrees, strict=True)
    for name, (longitude, latitude, height), covariance, north in places:
        place = {"B_deg": or_none(latitude), "L_deg": or_none(longitude), "H_m": or_none(height)}
        empty = {"X_m": None, "Y_m": None, "Z_m": None, "sheet_north_deg": or_none(north)}
        rows.append({**_head(name, source, roles, covariance), **place, **empty, **_covariance(covariance)})
    return rows


def _head(name: str, source: SourcePoints, roles: Mapping[str, str], covariance: Array) -> dict[str, object]:
    weighting = "weighted" if np.isfinite(covariance).any() and np.nansum(np.abs(covariance)) > 0 else "fixed"
    return {"point": name, "role": roles.get(name, "control"), "source": source.source, "weighting": weighting}


def _covariance(covariance: Array) -> dict[str, float | None]:
    known = np.isfinite(covariance).any()
    return covariance_columns(np.nan_to_num(covariance) if known else None)


def _merge(rows: list[dict[str, object]], events: list[Event]) -> list[dict[str, object]]:
    """One row per point: the first source wins (control before sheets), and it is said."""
    merged: dict[str, dict[str, object]] = {}
    for row in rows:
        point = str(row["point"])
        if point in merged:
            first = merged[point]["source"]
            message = f"{point} is given by {first} and by {row['source']}; {first} is used"
            events.append(Event("warning", "given_twice", point, message))
        else:
            merged[point] = row
    return list(merged.values())


def _unplaced(roles: Mapping[str, str], rows: Sequence[Mapping[str, object]]) -> list[Event]:
    placed = {row["point"] for row in rows}
    return [
        Event("warning", "no_coordinates", point, f"{point} is listed in control but no sheet gives its coordinates")
        for point in roles
        if point not in placed
    ]
