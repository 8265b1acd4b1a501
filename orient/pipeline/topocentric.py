"""Stage `topocentric`: T (north, east, up at the origin) and T' (T turned by the convergence), with covariance.

The origin is the approximate station's nadir point when it is known, else the mean of the points; its height is the
ground height of photo.toml, else the mean height. Local Cartesian points pass through: T = T' = their X, Y, Z.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from orient.errors import OrientError
from orient.geodesy.convergence import convergence
from orient.geodesy.ellipsoid import prime_vertical_polynomial, prime_vertical_radius
from orient.geodesy.topocentric import Origin, Radius, horizon_axes, topocentric_from_geographic, turn_to_grid
from orient.pipeline.ground import Ground, ground_of
from orient.pipeline.tables import Array, columns, covariance_columns, covariances, number, single
from orient.units import DEGREES_PER_RADIAN, RADIANS_PER_DEGREE
from orient.values import Event, Outcome, Row, Settings, Tables
from orient.words import counted

EXACT = "exact"
RADII: Mapping[str, Radius] = {EXACT: prime_vertical_radius, "polynomial": prime_vertical_polynomial}


def compute(inputs: Mapping[str, Tables], settings: Settings) -> Outcome:
    """Outcome with one `topocentric_frame` row and the `topocentric_point` rows."""
    photo = single(inputs["photo"], "photo")
    ground = ground_of(photo)
    points = inputs["bl"]["geographic_point"]
    radius = str(settings.get("radius", EXACT))
    if ground.is_local:
        if radius != EXACT:
            raise OrientError("local Cartesian ground has no radius N", "Leave it at --radius exact.")
        return _pass_through(points, ground)
    origin = _origin(photo, points)
    gamma = 0.0
    if ground.central_meridian is not None:
        gamma = float(convergence(origin.B, origin.L, ground.central_meridian, ground.figure))
    place, known = _assumed(columns(points, "B_deg", "L_deg", "H_m"), origin)
    latitude, longitude = place[:, 0] * RADIANS_PER_DEGREE, place[:, 1] * RADIANS_PER_DEGREE
    given = (latitude, longitude, place[:, 2], origin, ground.figure)
    in_t = topocentric_from_geographic(*given, RADII[radius])
    to_t_prime = _grid_turn(gamma) @ horizon_axes(latitude, longitude, origin)
    covariance = to_t_prime @ covariances(points) @ to_t_prime.transpose(0, 2, 1)
    rows = _rows(points, known, in_t, turn_to_grid(in_t, gamma), to_t_prime[:, :, 2], covariance)
    frame: dict[str, str | float | None] = {
        "kind": "topocentric",
        "B_N_deg": origin.B * DEGREES_PER_RADIAN,
        "L_N_deg": origin.L * DEGREES_PER_RADIAN,
        "H_N_m": origin.H,
        "gamma_deg": gamma * DEGREES_PER_RADIAN,
        "central_meridian_deg": number(photo, "central_meridian_deg"),
        "a_m": ground.figure.a_m,
        "e2": ground.figure.e2,
    }
    summary = f"{counted(len(rows), 'point')}, gamma {gamma * DEGREES_PER_RADIAN:+.6f} deg"
    events = _partial_events(rows)
    if radius != EXACT:
        events.append(_radius_event(points, in_t - topocentric_from_geographic(*given)))
    return Outcome({"topocentric_frame": [frame], "topocentric_point": rows}, events, summary)


def _radius_event(points: Sequence[Row], difference: Array) -> Event:
    """How far the historical N moves the points (n, 3)."""
    lengths = np.linalg.norm(difference, axis=1)
    worst = int(np.argmax(lengths))
    largest, point = float(lengths[worst]), str(points[worst]["point"])
    message = f"N by the paper's polynomial: coordinates are up to {largest:.1e} m off the exact ones (point {point})"
    return Event("info", "radius_polynomial", point, message, largest)


def _pass_through(points: Sequence[Row], ground: Ground) -> Outcome:
    xyz = columns(points, "X_m", "Y_m", "Z_m")
    is_given = np.isfinite(xyz)
    known = [_known(*row) for row in is_given]
    # an assumed coordinate where none is given: the mean of the given ones, 0 when there are none
    assumed = np.sum(xyz, axis=0, where=is_given) / np.maximum(is_given.sum(axis=0), 1)
    place = np.where(is_given, xyz, assumed)
    up = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    rows = _rows(points, known, place, place, up, covariances(points))
    empty = ("B_N_deg", "L_N_deg", "H_N_m", "gamma_deg", "central_meridian_deg", "a_m", "e2")
    frame: dict[str, str | None] = {"kind": f"local_{ground.handedness}", **dict.fromkeys(empty)}
    many = counted(len(rows), "local Cartesian point")
    said = Event("info", "passed_through", "", f"{many} passed through without a change")
    events = [said, *_partial_events(rows)]
    summary = f"{counted(len(rows), 'point')}, local Cartesian, passed through"
    return Outcome({"topocentric_frame": [frame], "topocentric_point": rows}, events, summary)


def _origin(photo: Row, points: Sequence[Row]) -> Origin:
    # a check point must not change anything, not even where T' begins
    control = [point for point in points if point["role"] == "control"] or points
    place = columns(control, "B_deg", "L_deg", "H_m")
    station = columns([photo], "station_B_deg", "station_L_deg")[0]
    if np.isnan(station).any():
        if np.isnan(place[:, :2]).all():
            raise OrientError("no point has a plan position", "Give at least three points with B, L and H.")
        station = _mean_position(place[:, :2])
    height = number(photo, "ground_height_m")
    if height is None:
        height = 0.0 if np.isnan(place[:, 2]).all() else float(np.nanmean(place[:, 2]))
    return Origin(station[0] * RADIANS_PER_DEGREE, station[1] * RADIANS_PER_DEGREE, height)


def _mean_position(place: Array) -> Array:
    """Mean B, L [deg]; longitudes are compared with the first one, so the date line does no harm."""
    known = place[~np.isnan(place).any(axis=1)]
    turns = np.round((known[:, 1] - known[0, 1]) / 360.0) * 360.0
    mean: Array = np.array([known[:, 0].mean(), (known[:, 1] - turns).mean()])
    return mean


def _assumed(place: Array, origin: Origin) -> tuple[Array, list[str]]:
    """Every point with all three coordinates, assumed where unknown, and which part of it is known."""
    known = [_known(*row) for row in np.isfinite(place)]
    nominal = np.array([origin.B * DEGREES_PER_RADIAN, origin.L * DEGREES_PER_RADIAN, origin.H])
    return np.where(np.isnan(place), nominal, place), known


def _known(first: bool, second: bool, third: bool) -> str:
    if first and second:
        return "XYZ" if third else "plan"
    return "height"


def _grid_turn(gamma: float) -> Array:
    """(3, 3) T' from T."""
    return np.asarray(turn_to_grid(np.eye(3), gamma), dtype=np.float64).T


def _rows(
    points: Sequence[Row], known: Sequence[str], in_t: Array, in_t_prime: Array, up: Array, covariance: Array
) -> list[dict[str, str | float | None]]:
    rows: list[dict[str, str | float | None]] = []
    for index, point in enumerate(points):
        matrix = covariance[index] if np.isfinite(covariance[index]).all() else None
        rows.append(
            {
                "point": str(point["point"]),
                "role": str(point["role"]),
                "weighting": str(point["weighting"]),
                "known": known[index],
                **dict(zip(("X_T_m", "Y_T_m", "Z_T_m"), in_t[index].tolist(), strict=True)),
                **dict(zip(("X_m", "Y_m", "Z_m"), in_t_prime[index].tolist(), strict=True)),
                **dict(zip(("up_X", "up_Y", "up_Z"), up[index].tolist(), strict=True)),
                **covariance_columns(matrix),
                "sheet": None if point["sheet_north_deg"] is None else str(point["source"]),
                "sheet_north_deg": number(point, "sheet_north_deg"),
            }
        )
    return rows


def _partial_events(rows: Sequence[Row]) -> list[Event]:
    words = {"plan": "the height", "height": "the plan position"}
    return [
        Event("info", "partial_point", str(row["point"]), f"{row['point']}: {words[str(row['known'])]} is not given")
        for row in rows
        if row["known"] != "XYZ"
    ]
