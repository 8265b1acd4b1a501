"""Stage `covariance`: where the ray of each point meets its height, and K = C Q C' of that place (seed 003).

The covariance is that of a new point read once more at this place: the part of the orientation with the full
cofactor matrix, the part of the reading, the part of the height. Source: seed 003, (1)-(3).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from orient.errors import OrientError
from orient.geometry.camera import Camera
from orient.geometry.rotation import matrix_from_quaternion
from orient.pipeline.camera import adjusted_camera, camera_effect
from orient.pipeline.frames import Frame, frame_of
from orient.pipeline.ground import ground_of
from orient.pipeline.resection import Observations, observations
from orient.pipeline.tables import Array, columns, covariances, or_none, required, single
from orient.solvers.ground_covariance import (
    RayJacobians,
    covariance_factor,
    error_ellipse,
    ground_covariance,
    pair_covariance,
    ray_at_height,
    ray_at_height_jacobians,
)
from orient.solvers.packed import unpack_upper
from orient.units import DEGREES_PER_RADIAN
from orient.values import Event, Outcome, Row, Settings, Tables

PARTS = ("XX", "XY", "YY")


@dataclass(frozen=True, slots=True)
class Oriented:
    """The orientation in the solver's right-handed frame, with the covariance (6+m, 6+m) of its elements.

    `camera` and the names of its m elements that were estimated; None when it was known.
    `scale`: variance of unit weight by which all cofactors are multiplied, in units of the one a priori.
    """

    station: Array
    rotation: Array
    f_mm: float
    covariance: Array
    scale: float
    camera: tuple[Camera, tuple[str, ...]] | None = None


@dataclass(frozen=True, slots=True)
class Meeting:
    """Where the rays meet the heights (right-handed frame), and in which axes that is told."""

    seen: Observations
    points: Array
    jacobians: RayJacobians
    axes: Array
    height_variance: Array
    reading_covariance: Array

    @property
    def met(self) -> list[int]:
        return [int(i) for i in np.flatnonzero(self.jacobians.determined)]


def compute(inputs: Mapping[str, Tables], settings: Settings) -> Outcome:
    """Outcome with `ground_covariance` rows and, when asked, all pairs."""
    photo = single(inputs["photo"], "photo")
    frame = frame_of(single(inputs["topocentric"], "topocentric_frame"), ground_of(photo))
    measured, _ = observations(inputs["refine"], inputs["topocentric"])
    seen, events = _placed(measured, inputs["resection"])
    oriented = replace(
        _oriented(inputs["resection"], frame),
        camera=adjusted_camera(photo, inputs["photo"], inputs["resection"]),
    )
    meeting = _meeting(seen, oriented, inputs["resection"], frame)
    events += _level_rays(meeting)
    rows = _rows(meeting, oriented, frame)
    tables: dict[str, Sequence[Row]] = {"ground_covariance": rows}
    if settings["pairs"]:
        tables["ground_covariance_pair"] = _pair_rows(meeting, oriented)
    return Outcome(tables, events, _summary(rows))


def _placed(measured: Observations, resection: Tables) -> tuple[Observations, list[Event]]:
    """Points given completely, or placed by the resection; at the others a ray has no known surface to meet."""
    adjusted = {row["point"] for row in resection.get("adjusted_point", ())}
    keep = [i for i, known in enumerate(measured.known) if known == "XYZ" or measured.points[i] in adjusted]
    kept = set(keep)
    left_out = [point for i, point in enumerate(measured.points) if i not in kept]
    events = [
        Event("info", "partly_given", point, f"{point}: only partly given and not adjusted; no ground covariance")
        for point in left_out
    ]
    return measured.at(keep), events


def _oriented(resection: Tables, frame: Frame) -> Oriented:
    row = single(resection, "orientation")
    packed = [required(entry, "value") for entry in resection["cofactor"] if entry["unknowns"] == "rotation"]
    Q = unpack_upper(np.array(packed))
    to_right_handed = np.eye(len(Q))
    to_right_handed[3:6, 3:6] = frame.partner
    scale = required(row, "variance_scale")
    Q = to_right_handed @ Q @ to_right_handed
    return Oriented(
        station=frame.right_handed(columns([row], "X_S_m", "Y_S_m", "Z_S_m")[0]),
        rotation=matrix_from_quaternion(columns([row], "q_w", "q_x", "q_y", "q_z")[0]),
        f_mm=required(row, "f_mm"),
        covariance=scale * Q,
        scale=scale / required(row, "sigma0_apriori_mm") ** 2,
    )


def _meeting(seen: Observations, oriented: Oriented, resection: Tables, frame: Frame) -> Meeting:
    adjusted = {str(row["point"]): row for row in resection.get("adjusted_point", ())}
    heights = frame.right_handed(_places(seen, adjusted))
    up = frame.right_handed(seen.up)
    image, by_camera, reading = _through_camera(seen, oriented)
    points = ray_at_height(image, oriented.station, oriented.rotation, oriented.f_mm, heights, up)
    jacobians = ray_at_height_jacobians(points, oriented.station, oriented.rotation, oriented.f_mm, up)
    jacobians = replace(jacobians, C=np.concatenate([jacobians.C, jacobians.J @ by_camera], axis=2))
    scale = required(single(resection, "orientation"), "variance_scale")
    return Meeting(seen, points, jacobians, _horizon(frame, up), _height_variance(seen, adjusted, scale), reading)


def _through_camera(seen: Observations, oriented: Oriented) -> tuple[Array, Array, Array]:
    """Image coordinates (n, 2), their partials (n, 2, m) by the estimated camera, their covariance (n, 2, 2)."""
    if oriented.camera is None:
        return seen.image, np.zeros((len(seen.image), 2, 0)), seen.image_covariance
    camera, names = oriented.camera
    image, by_reading, by_camera = camera_effect(camera, names, seen.image_rows)
    return image, by_camera, by_reading @ seen.image_covariance @ by_reading.transpose(0, 2, 1)


def _places(seen: Observations, adjusted: Mapping[str, Row]) -> Array:
    """(n, 3) a place at the height of each point: adjusted where the resection moved it, else as given."""
    return np.array(
        [
            columns([adjusted.get(point, row)], "X_m", "Y_m", "Z_m")[0]
            for point, row in zip(seen.points, seen.rows, strict=True)
        ]
    ).reshape(-1, 3)


def _height_variance(seen: Observations, adjusted: Mapping[str, Row], scale: float) -> Array:
    """(n,) variance of the given heights, 0 if taken as known; of the adjusted height where none was given."""
    covariance = np.nan_to_num(covariances(seen.rows))
    for i in np.flatnonzero(seen.known == "plan"):
        covariance[i] = scale * covariances([adjusted[seen.points[int(i)]]], "q_", "")[0]
    variance: Array = np.einsum("ni,nij,nj->n", seen.up, covariance, seen.up)
    return variance


def _horizon(frame: Frame, up: Array) -> Array:
    """(n, 2, 3) unit vectors X (grid north) and Y (grid east) in the horizon of each point, right-handed frame."""
    x_axis = frame.right_handed(np.array([1.0, 0.0, 0.0]))
    level = x_axis - (up @ x_axis)[:, None] * up
    first = level / np.linalg.norm(level, axis=1)[:, None]
    second = np.cross(up, first) * np.linalg.det(frame.partner)
    return np.stack([first, second], axis=1)


def _rows(meeting: Meeting, oriented: Oriented, frame: Frame) -> list[Row]:
    seen, axes, known = meeting.seen, meeting.axes, meeting.seen.known
    reading = oriented.scale * meeting.reading_covariance
    found = ground_covariance(meeting.jacobians, oriented.covariance, reading, meeting.height_variance)
    in_plan = [axes @ part @ axes.transpose(0, 2, 1) for part in (found.orientation, found.reading, found.height)]
    stored = frame.right_handed(meeting.points)
    apart = np.einsum("nij,nj->ni", axes, meeting.points - frame.right_handed(seen.ground))
    return [
        {
            "point": seen.points[i],
            "role": seen.roles[i],
            **dict(zip(("X_m", "Y_m", "Z_m"), stored[i].tolist(), strict=True)),
            **_apart(apart[i], known[i]),
            **_part("K", in_plan[0][i]),
            **_part("reading", in_plan[1][i]),
            **_part("height", in_plan[2][i]),
            **_accuracy(sum(part[i] for part in in_plan)),
        }
        for i in meeting.met
    ]


def _apart(apart: Array, known: str) -> dict[str, float | None]:
    if known == "height":
        return {"dX_m": None, "dY_m": None}
    return {"dX_m": float(apart[0]), "dY_m": float(apart[1])}


def _part(name: str, covariance: Array) -> dict[str, float]:
    values = (covariance[0, 0], covariance[0, 1], covariance[1, 1])
    return {f"{name}_{part}_m2": float(value) for part, value in zip(PARTS, values, strict=True)}


def _accuracy(total: Array) -> dict[str, float]:
    ellipse = error_ellipse(total)
    return {
        "sigma_X_m": float(np.sqrt(total[0, 0])),
        "sigma_Y_m": float(np.sqrt(total[1, 1])),
        "ellipse_a_m": ellipse.a,
        "ellipse_b_m": ellipse.b,
        "ellipse_azimuth_deg": ellipse.azimuth * DEGREES_PER_RADIAN,
    }


def _pair_rows(meeting: Meeting, oriented: Oriented) -> list[Row]:
    factor = meeting.axes @ covariance_factor(meeting.jacobians, oriented.covariance)
    met = np.array(meeting.met, dtype=np.intp)
    first, second = (met[index] for index in np.triu_indices(len(met), 1))
    pairs = pair_covariance(factor, first, second)
    names = meeting.seen.points
    keys = ("K_XX_m2", "K_XY_m2", "K_YX_m2", "K_YY_m2")
    return [
        {
            "point_i": names[i],
            "point_j": names[j],
            **dict(zip(keys, (or_none(float(value)) for value in K.ravel()), strict=True)),
        }
        for i, j, K in zip(first, second, pairs, strict=True)
    ]


def _level_rays(meeting: Meeting) -> list[Event]:
    return [
        Event("warning", "level_ray", point, f"{point}: its ray runs level and does not meet its height; no covariance")
        for point, is_met in zip(meeting.seen.points, meeting.jacobians.determined, strict=True)
        if not is_met
    ]


def _summary(rows: Sequence[Row]) -> str:
    if not rows:
        raise OrientError("no ray meets the height of its point", "The photo looks along the horizon.")
    typical = float(np.median(columns(rows, "ellipse_a_m")))
    return f"{len(rows)} points, median semi-major axis {typical:.3g} m"
