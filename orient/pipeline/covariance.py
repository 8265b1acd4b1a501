"""Stage `covariance`: where the ray of each point meets its height, and K = C Q C' of that place (seed 003).

The covariance is that of a new point read once more at this place: the part of the orientation with the full
cofactor matrix, the part of the reading, the part of the height. Source: seed 003, (1)-(3).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from orient.errors import GeometryError, OrientError
from orient.pipeline.camera import measured_of
from orient.pipeline.element_use import use_rows
from orient.pipeline.frames import Frame, frame_of
from orient.pipeline.ground import ground_of
from orient.pipeline.ground_accuracy import frame_places, map_rows
from orient.pipeline.ground_budget import ELEMENTS, budget_rows
from orient.pipeline.normal_case import Case, normal_case_tables
from orient.pipeline.observations import Observations, observations
from orient.pipeline.oriented import Oriented, oriented_by
from orient.pipeline.plan_covariance import (
    PlanCovariance,
    ground_columns,
    horizon,
    image_columns,
    plan_covariance,
    scale_columns,
)
from orient.pipeline.tables import (
    Array,
    by_names,
    columns,
    covariances,
    names,
    nullable,
    or_none,
    required,
    rows_at,
    single,
)
from orient.solvers.ground_covariance import (
    RayJacobians,
    covariance_factor,
    pair_covariance,
    ray_at_height,
    ray_at_height_jacobians,
)
from orient.values import Columns, Event, Outcome, Row, Settings, Tables
from orient.words import counted


@dataclass(frozen=True, slots=True)
class Meeting:
    """Where the rays meet the heights (right-handed frame), and in which axes that is told.

    C of the jacobians has a column for everything that a ray depends on: elements, interior orientation.
    """

    seen: Observations
    points: Array
    jacobians: RayJacobians
    axes: Array
    height_variance: Array
    reading_covariance: Array

    @property
    def met(self) -> list[int]:
        return [int(i) for i in np.flatnonzero(self.jacobians.determined)]

    @property
    def plan_partials(self) -> Array:
        """(m, 2, 6+k) of the plan position of the points that are met, by all that a ray depends on."""
        return np.asarray(self.axes[self.met] @ self.jacobians.at(self.met).C)


def compute(inputs: Mapping[str, Tables], settings: Settings) -> Outcome:
    """Outcome with `ground_covariance` rows and, when asked, all pairs."""
    photo = single(inputs["photo"], "photo")
    frame = frame_of(single(inputs["topocentric"], "topocentric_frame"), ground_of(photo))
    measured, _ = observations(inputs["refine"], inputs["topocentric"])
    oriented = oriented_by(inputs["photo"], inputs["refine"], inputs["resection"], frame)
    seen, events = _placed(measured, inputs["resection"])
    meeting = _meeting(seen, oriented, inputs["resection"], frame)
    events += _level_rays(meeting)
    plan = _plan(meeting, oriented)
    rows = _rows(meeting, plan, frame)
    map_of_frame, without_map = _map_rows(photo, meeting, oriented, frame, settings)
    events += without_map
    tables: dict[str, Sequence[Row]] = {
        "ground_covariance": rows,
        "ground_covariance_image": _image_rows(meeting, plan),
        "ground_accuracy": map_of_frame,
        "element_use": [] if oriented.rays.camera else use_rows(oriented, meeting.plan_partials[:, :, :ELEMENTS]),
        "error_budget": _budget_rows(meeting, plan, oriented),
        **normal_case_tables(_case(inputs["resection"], meeting, oriented, plan)),
    }
    if settings["pairs"]:
        tables["ground_covariance_pair"] = _pair_rows(meeting, oriented)
    return Outcome(tables, events, _summary(rows))


def _map_rows(
    photo: Row, meeting: Meeting, oriented: Oriented, frame: Frame, settings: Settings
) -> tuple[Sequence[Row], list[Event]]:
    """The map of the frame, at the mean height of the points and for a reading like theirs; none for a folded lens."""
    side, height_sigma = int(settings["map_side"] or 0), float(settings["map_height_sigma_m"] or 0.0)
    points = frame.right_handed(meeting.points[meeting.met])
    height = float(np.mean(points[:, 2] if frame.is_local else frame.geographic(points)[:, 2]))
    reading = oriented.scale * np.mean(meeting.seen.image_covariance[meeting.met], axis=0)
    places = frame_places(photo, side)
    principal_point = columns([photo], "x0_mm", "y0_mm")[0]
    comparator = oriented.rays.comparator(places + principal_point)
    try:
        through = oriented.rays.at_places(places, comparator, principal_point)
    except GeometryError as error:
        message = f"no map of the accuracy over the frame: the estimated lens has no inverse there ({error.message})"
        return [], [Event("warning", "no_map", "", message)]
    return map_rows(places, through, oriented, frame, height, reading, height_sigma), []


def _case(resection: Tables, meeting: Meeting, oriented: Oriented, plan: PlanCovariance) -> Case:
    """What seed 003 asks of the photo; flat ground is flat in the Cartesian Z of T', curvature counts as relief.

    The seed takes the interior orientation as known: its formulas are compared with K under this condition.
    """
    seen = meeting.seen.at(meeting.met)
    C = meeting.plan_partials[:, :, :ELEMENTS]
    elements = oriented.variance_scale * oriented.rays.with_known_interior
    in_image = plan.in_image(np.asarray(C @ elements @ C.transpose(0, 2, 1)))
    residuals = resection["image_residual"]
    return Case(
        control=columns(residuals, "x_mm", "y_mm")[np.array(names(residuals, "role")) == "control"],
        points=seen.points,
        image=seen.image,
        heights=meeting.points[meeting.met, 2],
        station_height=float(oriented.station[2]),
        rotation=oriented.rotation,
        f_mm=oriented.f_mm,
        reading=oriented.scale * seen.image_covariance,
        K=np.diagonal(in_image, axis1=1, axis2=2),
        adjusted=len(resection.get("adjusted_point", ())),
        estimated=0 if oriented.rays.camera is None else len(oriented.rays.camera[1]),
    )


def _placed(measured: Observations, resection: Tables) -> tuple[Observations, list[Event]]:
    """Points given completely, or placed by the resection; at the others a ray has no known surface to meet."""
    adjusted = set(names(resection.get("adjusted_point", ())))
    keep = [i for i, known in enumerate(measured.known) if known == "XYZ" or measured.points[i] in adjusted]
    kept = set(keep)
    left_out = [point for i, point in enumerate(measured.points) if i not in kept]
    events = [
        Event("info", "partly_given", point, f"{point}: only partly given and not adjusted; no ground covariance")
        for point in left_out
    ]
    return measured.at(keep), events


def _meeting(seen: Observations, oriented: Oriented, resection: Tables, frame: Frame) -> Meeting:
    adjusted = _Adjusted.of(resection)
    heights = frame.right_handed(_places(seen, adjusted))
    up = frame.right_handed(seen.up)
    through = oriented.rays.seen(seen.image, seen.comparator, measured_of(seen.image_rows))
    seen, reading = replace(seen, image=through.image), through.reading(seen.image_covariance)
    points = ray_at_height(seen.image, oriented.station, oriented.rotation, oriented.f_mm, heights, up)
    jacobians = ray_at_height_jacobians(points, oriented.station, oriented.rotation, oriented.f_mm, up)
    T = through.jacobian(jacobians.C, jacobians.J)
    jacobians = replace(jacobians, C=T)
    scale = required(single(resection, "orientation"), "variance_scale")
    return Meeting(seen, points, jacobians, horizon(frame, up), _height_variance(seen, adjusted, scale), reading)


@dataclass(frozen=True, slots=True)
class _Adjusted:
    """The points that the resection moved, and the place of each in the list."""

    rows: Sequence[Row]
    place_of: Mapping[str, int]

    @classmethod
    def of(cls, resection: Tables) -> "_Adjusted":
        rows = resection.get("adjusted_point", ())
        return cls(rows, {point: place for place, point in enumerate(names(rows))})


def _places(seen: Observations, adjusted: _Adjusted) -> Array:
    """(n, 3) a place at the height of each point: adjusted where the resection moved it, else as given."""
    places = seen.ground.copy()
    moved = [i for i, point in enumerate(seen.points) if point in adjusted.place_of]
    if moved:
        at = [adjusted.place_of[seen.points[i]] for i in moved]
        places[moved] = columns(adjusted.rows, "X_m", "Y_m", "Z_m")[at]
    return places


def _height_variance(seen: Observations, adjusted: _Adjusted, scale: float) -> Array:
    """(n,) variance of the given heights, 0 if taken as known; of the adjusted height where none was given."""
    covariance = np.nan_to_num(covariances(seen.rows))
    plan = np.flatnonzero(seen.known == "plan")
    at = [adjusted.place_of[seen.points[i]] for i in plan.tolist()]
    if at:
        covariance[plan] = scale * covariances(rows_at(adjusted.rows, at), "q_", "")
    variance: Array = np.einsum("ni,nij,nj->n", seen.up, covariance, seen.up)
    return variance


def _plan(meeting: Meeting, oriented: Oriented) -> PlanCovariance:
    """Covariances of the points whose rays meet their heights, in the order of `met`."""
    reading = oriented.scale * meeting.reading_covariance[meeting.met]
    jacobians = meeting.jacobians.at(meeting.met)
    axes, heights = meeting.axes[meeting.met], meeting.height_variance[meeting.met]
    return plan_covariance(jacobians, axes, oriented.ray_covariance, reading, heights)


def _budget_rows(meeting: Meeting, plan: PlanCovariance, oriented: Oriented) -> Sequence[Row]:
    points = [meeting.seen.points[i] for i in meeting.met]
    T = meeting.plan_partials
    return budget_rows(points, T, oriented.rays, oriented.variance_scale, plan.reading, plan.height)


def _rows(meeting: Meeting, plan: PlanCovariance, frame: Frame) -> Columns:
    seen, met = meeting.seen, meeting.met
    stored = frame.right_handed(meeting.points)
    apart = np.einsum("nij,nj->ni", meeting.axes, meeting.points - frame.right_handed(seen.ground))
    apart = np.where((seen.known == "height")[:, None], np.nan, apart)
    return Columns(
        {
            "point": [seen.points[i] for i in met],
            "role": [seen.roles[i] for i in met],
            **by_names(("X_m", "Y_m", "Z_m"), stored[met]),
            "dX_m": nullable(apart[met, 0]),
            "dY_m": nullable(apart[met, 1]),
            **ground_columns(plan),
        }
    )


def _image_rows(meeting: Meeting, plan: PlanCovariance) -> Columns:
    points = [meeting.seen.points[i] for i in meeting.met]
    return Columns({"point": points, **scale_columns(plan), **image_columns(plan)})


def _pair_rows(meeting: Meeting, oriented: Oriented) -> list[Row]:
    factor = meeting.axes @ covariance_factor(meeting.jacobians, oriented.ray_covariance)
    met = np.array(meeting.met, dtype=np.intp)
    first, second = (met[index] for index in np.triu_indices(len(met), 1))
    pairs = pair_covariance(factor, first, second)
    points = meeting.seen.points
    keys = ("K_XX_m2", "K_XY_m2", "K_YX_m2", "K_YY_m2")
    return [
        {
            "point_i": points[i],
            "point_j": points[j],
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


def _summary(rows: Columns) -> str:
    if not len(rows):
        raise OrientError("no ray meets the height of its point", "The photo looks along the horizon.")
    typical = float(np.median(columns(rows, "ellipse_a_m")))
    return f"{counted(len(rows), 'point')}, median semi-major axis {typical:.3g} m"
