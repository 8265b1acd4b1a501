"""The map layers: control, excluded and check points, residual vectors, error ellipses, footprint, station."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np

from orient.errors import GeometryError
from orient.export.layer_fields import (
    ELLIPSE_FIELDS,
    FOOTPRINT_FIELDS,
    POINT_FIELDS,
    STATION_FIELDS,
    VECTOR_FIELDS,
    Field,
)
from orient.export.map_system import MapSystem
from orient.export.solved import Solved, stored_covariance
from orient.geometry.camera import Measured, corrected
from orient.geometry.frame_centre import frame_centre
from orient.geometry.vertical_photo import grid_layout
from orient.pipeline.ground_accuracy import seen_ground
from orient.pipeline.image_corrections import air_and_curvature
from orient.pipeline.plan_covariance import horizon
from orient.pipeline.tables import Array, columns, required
from orient.units import RADIANS_PER_DEGREE
from orient.values import Row, Scalar

Kind = Literal["Point", "LineString", "Polygon"]
CORNERS = 64
"""Of a drawn ellipse."""
EDGE = 24
"""Places along each edge of the frame, for the footprint."""
ROOM = 0.06
"""Length of a typical drawn vector or largest semi-axis, as part of the extent of the points."""
LEVEL = 0.9


Feature = tuple[Array, list[Scalar]]
"""Places on the map (n, 2), values in the order of the fields."""


@dataclass(frozen=True, slots=True)
class Layer:
    """Features of one kind; `features()` makes them one after the other, they are never all in memory."""

    name: str
    title: str
    kind: Kind
    fields: Sequence[Field]
    features: Callable[[], Iterator[Feature]]


def map_layers(solved: Solved, system: MapSystem, magnify: float | None) -> list[Layer]:
    """All layers, also those without a feature: a style or a program can rely on them."""
    rows = solved.current.tables["covariance"]["ground_covariance"]
    roles = {str(row["point"]): str(row["role"]) for row in solved.current.tables["resection"]["image_residual"]}
    factor = magnify if magnify is not None else _magnification(solved, rows)
    names = (("control", "Control"), ("check", "Check points"), ("excluded", "Excluded points"))
    points = {role: partial(_points, solved, system, rows, roles, role) for role, _ in names}
    vectors = partial(_vectors, solved, system, rows, roles, factor)
    ellipses = partial(_ellipses, solved, system, rows, roles, factor)
    footprint, station = partial(_footprint, solved, system, rows), partial(_station, solved, system)
    return [
        *(Layer(role, title, "Point", POINT_FIELDS, points[role]) for role, title in names),
        Layer("residuals", "Residuals on the ground", "LineString", VECTOR_FIELDS, vectors),
        Layer("ellipses", "Error ellipses", "Polygon", ELLIPSE_FIELDS, ellipses),
        Layer("footprint", "Footprint", "Polygon", FOOTPRINT_FIELDS, footprint),
        Layer("station", "Projection centre", "Point", STATION_FIELDS, station),
    ]


def _points(
    solved: Solved, system: MapSystem, rows: Sequence[Row], roles: Mapping[str, str], role: str
) -> Iterator[Feature]:
    """Every point of this role with a place on the ground that is measured in the photo."""
    tables = solved.current.tables
    given = {str(row["point"]): row for row in tables["bl"]["geographic_point"]}
    by_ray = {str(row["point"]): row for row in rows}
    residual = {str(row["point"]): row for row in tables["resection"]["image_residual"]}
    placed = [row for row in tables["topocentric"]["topocentric_point"] if roles.get(str(row["point"])) == role]
    if not placed:
        return
    places = _on_map(solved, system, [given[str(row["point"])] for row in placed], placed)
    for row, place in zip(placed, places, strict=True):
        name = str(row["point"])
        earth, ray, v = given[name], by_ray.get(name, {}), residual[name]
        yield (
            place[None, :],
            [
                name,
                roles[name],
                row["weighting"],
                *(earth[key] for key in ("B_deg", "L_deg", "H_m")),
                *(row[key] for key in ("X_m", "Y_m", "Z_m")),
                *(1000.0 * required(v, key) for key in ("vx_mm", "vy_mm")),
                *(ray.get(key) for key in ("dX_m", "dY_m", "sigma_X_m", "sigma_Y_m")),
            ],
        )


def _on_map(solved: Solved, system: MapSystem, given: Sequence[Row], placed: Sequence[Row]) -> Array:
    """(n, 2): from B, L, H as given where they are complete, else from the project's frame."""
    places = system.of_stored(columns(placed, "X_m", "Y_m", "Z_m"))
    if solved.frame.is_local:
        return places
    earth = columns(given, "B_deg", "L_deg", "H_m") * [RADIANS_PER_DEGREE, RADIANS_PER_DEGREE, 1.0]
    whole = np.isfinite(earth).all(axis=1)
    places[whole] = system.of_geographic(earth[whole])
    return places


def _horizons(solved: Solved, rows: Sequence[Row]) -> Array:
    """(n, 2, 3) axes X and Y in the horizon of each ground point, in the project's frame."""
    ups = {str(row["point"]): row for row in solved.current.tables["topocentric"]["topocentric_point"]}
    up = columns([ups[str(row["point"])] for row in rows], "up_X", "up_Y", "up_Z")
    return solved.frame.right_handed(horizon(solved.frame, solved.frame.right_handed(up)))


def _vectors(
    solved: Solved, system: MapSystem, rows: Sequence[Row], roles: Mapping[str, str], factor: float
) -> Iterator[Feature]:
    """From the given place towards where the image ray meets the height of the point."""
    known = [row for row in rows if row["dX_m"] is not None and str(row["point"]) in roles]
    apart, ray = columns(known, "dX_m", "dY_m"), columns(known, "X_m", "Y_m", "Z_m")
    step = np.einsum("ni,nij->nj", apart, _horizons(solved, known))
    starts, ends = system.of_stored(ray - step), system.of_stored(ray + (factor - 1.0) * step)
    for row, start, end, d in zip(known, starts, ends, apart.tolist(), strict=True):
        name = str(row["point"])
        yield np.stack([start, end]), [name, roles[name], *d, float(np.hypot(*d)), factor]


def _ellipses(
    solved: Solved, system: MapSystem, rows: Sequence[Row], roles: Mapping[str, str], factor: float
) -> Iterator[Feature]:
    """A ring, anticlockwise on the map, of the standard ellipse about the place of the ray."""
    known = [row for row in rows if str(row["point"]) in roles]
    turn = np.linspace(0.0, 2.0 * np.pi, CORNERS + 1)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    for row, axes in zip(known, _horizons(solved, known), strict=True):
        a, b, azimuth = (required(row, f"ellipse_{key}") for key in ("a_m", "b_m", "azimuth_deg"))
        s, c = np.sin(azimuth * RADIANS_PER_DEGREE), np.cos(azimuth * RADIANS_PER_DEGREE)
        plan = factor * np.array([[c, -s], [s, c]]) @ (np.array([[a], [b]]) * circle)
        ring = system.of_stored(columns([row], "X_m", "Y_m", "Z_m") + plan.T @ axes)
        name = str(row["point"])
        yield _ring(ring), [name, roles[name], a, b, azimuth, factor]


def _ring(places: Array) -> Array:
    """Closed to the last bit, anticlockwise, as RFC 7946 wants it."""
    x, y = places.T
    area = float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))
    ring = places if area > 0 else places[::-1]
    return np.vstack([ring[:-1], ring[:1]])


def _footprint(solved: Solved, system: MapSystem, rows: Sequence[Row]) -> Iterator[Feature]:
    """The edge of the frame on the mean height of the points; no feature if nothing of it meets the ground."""
    photo = solved.photo
    width, height_mm = required(photo, "frame_width_mm"), required(photo, "frame_height_mm")
    grid = grid_layout(width, height_mm, EDGE + 1, EDGE + 1).reshape(EDGE + 1, EDGE + 1, 2)
    edge = np.vstack([grid[0, :-1], grid[:-1, -1], grid[-1, :0:-1], grid[:0:-1, 0]]) + np.array(frame_centre(photo))
    points = columns(rows, "X_m", "Y_m", "Z_m")
    height = float(np.mean(points[:, 2] if solved.frame.is_local else solved.frame.geographic(points)[:, 2]))
    try:
        clear = corrected(solved.camera, Measured(edge, np.zeros_like(edge)))
        air, curvature = air_and_curvature(clear, photo)
        image = corrected(solved.camera, Measured(edge, air + curvature))
    except GeometryError:
        return
    ground, _ = seen_ground(image, solved.station, solved.rotation, solved.f_mm, solved.frame, height)
    seen = np.isfinite(ground).all(axis=1) & ((ground - solved.station) @ solved.rotation[:, 2] < 0)
    if seen.sum() < 3:
        return
    places = system.of_stored(solved.frame.right_handed(ground[seen]))
    values: list[Scalar] = [str(photo["name"]), height, int(seen.all())]
    yield _ring(np.vstack([places, places[:1]])), values


def _station(solved: Solved, system: MapSystem) -> Iterator[Feature]:
    row = solved.orientation
    place = system.of_stored(columns([row], "X_S_m", "Y_S_m", "Z_S_m"))
    sigmas = np.sqrt(np.diag(stored_covariance(solved))[:3]).tolist()
    angles = {
        str(angle["angle"]): angle["value_deg"]
        for angle in solved.current.tables["resection"]["orientation_angle"]
        if (angle["triple"], angle["frame"]) == ("opk", "ground")
    }
    sigma0 = row["sigma0_mm"]
    yield (
        place,
        [
            str(solved.photo["name"]),
            *(row[key] for key in ("B_S_deg", "L_S_deg", "H_S_m", "X_S_m", "Y_S_m", "Z_S_m")),
            *sigmas,
            *(angles[key] for key in ("omega", "phi", "kappa")),
            *(row[key] for key in ("q_w", "q_x", "q_y", "q_z", "f_mm")),
            None if sigma0 is None else 1000.0 * float(sigma0),
            row["redundancy"],
        ],
    )


def _magnification(solved: Solved, rows: Sequence[Row]) -> float:
    """A round number that makes nine of ten vectors and all ellipses visible beside the extent of the points."""
    lengths = np.hypot(*columns([row for row in rows if row["dX_m"] is not None], "dX_m", "dY_m").T)
    axes = columns(rows, "ellipse_a_m")[:, 0]
    size = max(float(np.quantile(lengths, LEVEL)) if len(lengths) else 0.0, float(np.max(axes)))
    extent = float(np.max(np.ptp(columns(rows, "X_m", "Y_m"), axis=0)))
    if not (size > 0 and extent > size):
        return 1.0
    power = 10.0 ** np.floor(np.log10(ROOM * extent / size))
    steps = [step * power for step in (1.0, 2.0, 5.0) if step * power <= ROOM * extent / size]
    return max(float(steps[-1]), 1.0)
