"""Stage `resection`: the exterior orientation of the photo by functional iteration, without start values."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from orient.errors import GeometryError
from orient.pipeline.calibration import Calibration, calibrate, candidates_of
from orient.pipeline.camera import camera_unknowns, with_element
from orient.pipeline.camera_rows import camera_events, camera_tables
from orient.pipeline.common_coefficients import CommonCoefficients, common_coefficients
from orient.pipeline.findings import in_stored_names, odd_points, resection_findings
from orient.pipeline.frames import Frame, frame_of
from orient.pipeline.ground import Ground, ground_of
from orient.pipeline.known_elements import KnownElements, known_elements, known_events, known_residual_rows
from orient.pipeline.resection_rows import result_tables
from orient.pipeline.resection_trace import adjusted_coefficient_rows, trace_tables
from orient.pipeline.tables import Array, columns, required, single
from orient.pipeline.weights import ground_weights
from orient.solvers.camera_unknowns import CameraUnknowns
from orient.solvers.engines import Engine
from orient.solvers.resection import Resection, resect
from orient.units import RADIANS_PER_DEGREE
from orient.values import Event, Outcome, Row, Settings, Tables

MINIMUM_POINTS = 3
HEIGHT_TOLERANCE_M = 1e-3
MAX_HEIGHT_ROUNDS = 10
MICROMETRES = 1000.0
INSEPARABLE = "cannot be separated"
NAMED = 10
"""Points that one event names; the tables hold all of them."""


@dataclass(frozen=True, slots=True)
class Observations:
    """Points that are both measured on the photo and placed on the ground, in the frame of T'."""

    points: Sequence[str]
    roles: Sequence[str]
    image: Array
    image_covariance: Array
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
            [self.rows[index] for index in keep],
            [self.image_rows[index] for index in keep] if self.image_rows else (),
        )

    @property
    def ground(self) -> Array:
        return columns(self.rows, "X_m", "Y_m", "Z_m")

    @property
    def up(self) -> Array:
        return columns(self.rows, "up_X", "up_Y", "up_Z")

    @property
    def known(self) -> Array:
        return np.array([str(row["known"]) for row in self.rows])


@dataclass(frozen=True, slots=True)
class Assignment:
    """Everything that a resection of this photo starts from."""

    photo: Row
    ground: Ground
    frame: Frame
    control: Observations
    shared: CommonCoefficients | None
    known: KnownElements
    interior: CameraUnknowns | None
    sigma0: float
    settings: Settings


def compute(inputs: Mapping[str, Tables], settings: Settings) -> Outcome:
    """Outcome with orientation, cofactors, iterations, equations and residuals."""
    task, check, events = _assignment(inputs, settings)
    task, found, calibration = _calibrated(task, inputs["photo"])
    steps = {} if calibration is None else {"calibration_step": calibration.rows}
    events += [] if calibration is None else calibration.events
    control, frame, sigma0 = task.control, task.frame, task.sigma0
    coefficients = () if task.shared is None else task.shared.coefficients
    traces = {**trace_tables(found, frame, control.points, task.interior, coefficients), **steps}
    if found.termination != "CONVERGED":
        full = np.flatnonzero(control.known == "XYZ")
        place = frame.right_handed(control.ground[full])
        events += odd_points(control.image[full], place, found.f_mm, [control.points[int(i)] for i in full])
        error = f"{found.termination.value}: {in_stored_names(found.message, frame)}"
        return Outcome(traces, events, error=error, hint=_hint(found))
    use_posteriori = settings["variance"] == "posteriori" and found.redundancy > 0
    events += resection_findings(found, frame, control.points, sigma0)
    rename = partial(in_stored_names, frame=frame)
    events += camera_events(found, task.interior, task.photo, sigma0, use_posteriori, rename)
    results = result_tables(found, frame, control, check, sigma0, use_posteriori, task.interior)
    camera = camera_tables(found, task.interior, sigma0, use_posteriori)
    shares = found.known_redundancy[len(found.known_redundancy) - len(task.known.observations) :]
    known = known_residual_rows(task.known, found.rotation, found.station, shares)
    events += known_events(known)
    adjusted = {"adjusted_coefficient": adjusted_coefficient_rows(found, task.shared, sigma0)}
    tables = {**results, **camera, "known_residual": known, **adjusted, **traces}
    return Outcome(tables, events, _summary(found, task.interior, sigma0))


def _assignment(inputs: Mapping[str, Tables], settings: Settings) -> tuple[Assignment, Observations, list[Event]]:
    """The control with all that is known of ground and camera; the check points; what could not be used."""
    photo = single(inputs["photo"], "photo")
    ground = ground_of(photo)
    frame = frame_of(single(inputs["topocentric"], "topocentric_frame"), ground)
    seen, events = observations(inputs["refine"], inputs["topocentric"])
    control, check = seen.only("control"), seen.only("check")
    _require_enough(control)
    sigma0 = required(photo, "sigma_image_mm")
    task = Assignment(
        photo=photo,
        ground=ground,
        frame=frame,
        control=control,
        shared=_shared(control, inputs.get("digitize", {}), frame, ground, settings),
        known=known_elements(inputs["photo"].get("known_element", ()), frame, sigma0),
        interior=camera_unknowns(photo, inputs["photo"], control.image_rows, settings, sigma0),
        sigma0=sigma0,
        settings=settings,
    )
    return task, check, events


def _calibrated(task: Assignment, photo_tables: Tables) -> tuple[Assignment, Resection, Calibration | None]:
    """The resection; with --calibrate auto, with the elements of the camera that its steps have chosen."""
    found = _solve(task)
    if task.interior is None or task.settings["calibrate"] != "auto" or found.termination != "CONVERGED":
        return task, found, None

    def solve(interior: CameraUnknowns, start: tuple[Array, Array] | None) -> Resection:
        return _solve(replace(task, interior=interior), start)

    def add(interior: CameraUnknowns, name: str) -> CameraUnknowns:
        return with_element(interior, name, task.photo, photo_tables, task.sigma0)

    rename = partial(in_stored_names, frame=task.frame)
    calibration = calibrate(task.interior, found, solve, add, candidates_of(task.interior), task.sigma0, rename)
    chosen = replace(task, interior=calibration.unknowns)
    return chosen, _solve(chosen), calibration


def _shared(
    control: Observations, digitize: Tables, frame: Frame, ground: Ground, settings: Settings
) -> CommonCoefficients | None:
    """What control points of one sheet share; nothing without errors, or when each point is to stand apart."""
    if settings["control"] == "fixed" or settings["correlation"] == "point":
        return None
    return common_coefficients(control.rows, digitize, frame, ground)


def observations(refine: Tables, topocentric: Tables) -> tuple[Observations, list[Event]]:
    """Pairs readings with ground points by name, and says what found no partner."""
    image = {str(row["point"]): row for row in refine["image_point"]}
    ground = {str(row["point"]): row for row in topocentric["topocentric_point"]}
    both = [point for point in image if point in ground]
    events = [
        *_unused(image, ground, "no_control", "are measured on the photo but have no ground coordinates, not used"),
        *_unused(ground, image, "not_measured", "have ground coordinates but are not measured on the photo, not used"),
    ]
    rows = [image[point] for point in both]
    packed = columns(rows, "cov_xx_mm2", "cov_xy_mm2", "cov_xy_mm2", "cov_yy_mm2")
    seen = Observations(
        points=both,
        roles=[str(ground[point]["role"]) for point in both],
        image=columns(rows, "x_mm", "y_mm"),
        image_covariance=packed.reshape(-1, 2, 2),
        rows=[ground[point] for point in both],
        image_rows=rows,
    )
    return seen, events


def _unused(here: Mapping[str, Row], there: Mapping[str, Row], code: str, message: str) -> list[Event]:
    """One event for all points that have no partner."""
    alone = [point for point in here if point not in there]
    if not alone:
        return []
    more = f" and {len(alone) - NAMED} more" if len(alone) > NAMED else ""
    listed = ", ".join(alone[:NAMED]) + more
    return [Event("warning", code, listed, f"{len(alone)} points {message}: {listed}", float(len(alone)))]


def _require_enough(control: Observations) -> None:
    full = [name for name, known in zip(control.points, control.known, strict=True) if known == "XYZ"]
    if len(full) < MINIMUM_POINTS:
        listed = f" ({', '.join(full)})" if full else ""
        raise GeometryError(
            f"{len(full)} control points with all three coordinates in the photo{listed}; "
            f"at least {MINIMUM_POINTS} are needed",
            "Measure more control points, or give the missing coordinates.",
        )


def _solve(task: Assignment, start: tuple[Array, Array] | None = None) -> Resection:
    """Resection; height-only points are set on the curved surface of their height again until they lie on it."""
    control, frame, sigma0, settings = task.control, task.frame, task.sigma0, task.settings
    own = None if task.shared is None else task.shared.own
    weights = ground_weights(control.rows, str(settings["control"]), sigma0, own)
    place, up = control.ground, control.up
    height_only = control.known == "height"
    for _ in range(MAX_HEIGHT_ROUNDS):
        free, weight = weights.at(up)
        found = resect(
            control.image,
            control.image_covariance / sigma0**2,
            frame.right_handed(place),
            required(task.photo, "f_mm"),
            ground_free=frame.right_handed_matrix(free) if free.any() else None,
            ground_weight=frame.right_handed_matrix(weight) if free.any() else None,
            common=None if task.shared is None else task.shared.in_solver(frame, sigma0),
            start_mask=control.known == "XYZ",
            approximate_station=_approximate_station(task.photo, frame, task.ground),
            fixed_station=task.known.fixed_station,
            observed=task.known.observations,
            interior=task.interior,
            start=start,
            tolerance=float(settings["tolerance"] or 0.0),
            max_iterations=int(settings["max_iterations"] or 0),
            names=control.points,
            engine=Engine(str(settings["engine"])),
            camera_above=None if task.photo["platform"] == "terrestrial" else np.array([0.0, 0.0, 1.0]),
        )
        if not height_only.any() or found.termination != "CONVERGED" or frame.origin is None:
            return found
        place, up, lift = _on_their_height(found, frame, task.ground, control, place, up)
        if lift < HEIGHT_TOLERANCE_M:
            return found
    return found


def _on_their_height(
    found: Resection, frame: Frame, ground: Ground, control: Observations, place: Array, up: Array
) -> tuple[Array, Array, float]:
    """Height-only points moved to the given height over their adjusted plan position; and by how much they moved."""
    index = np.flatnonzero(control.known == "height")
    given = frame.geographic(place[index])[:, 2]
    adjusted = frame.geographic(frame.right_handed(found.ground[index]))
    moved, verticals = place.copy(), up.copy()
    moved[index] = frame.from_geographic(adjusted[:, 0], adjusted[:, 1], given)
    above = frame.from_geographic(adjusted[:, 0], adjusted[:, 1], given + 1.0)
    verticals[index] = above - moved[index]
    return moved, verticals, float(np.linalg.norm(moved - place, axis=1).max())


def _approximate_station(photo: Row, frame: Frame, ground: Ground) -> Array | None:
    """The approximate station in the right-handed frame, if the photo states one completely."""
    geographic = columns([photo], "station_B_deg", "station_L_deg", "station_H_m")[0]
    local = columns([photo], "station_X_m", "station_Y_m", "station_Z_m")[0]
    if frame.origin is None:
        return None if np.isnan(local).any() else frame.right_handed(local)
    if not np.isnan(geographic[:2]).any() and np.isnan(geographic[2]):
        return None
    if np.isnan(geographic).any():
        if np.isnan(local).any():
            return None
        longitude, latitude, height = ground.geographic_from_geocentric(local[None, :])[0]
        geographic = np.array([latitude, longitude, height])
    latitude, longitude = geographic[:2] * RADIANS_PER_DEGREE
    place = frame.from_geographic(np.array([latitude]), np.array([longitude]), geographic[2:])
    return frame.right_handed(place[0])


def _hint(found: Resection) -> str:
    if INSEPARABLE in found.message:
        name = found.message.split(" ", 1)[0]
        return (
            f"Leave {name} out of --estimate, give its standard deviation in photo.toml, or add control at other "
            "heights or an oblique view."
        )
    return {
        "BEHIND_CAMERA": "Check signs and axes of the image coordinates and the order of the ground coordinates.",
        "BELOW_GROUND": "X and Y of the ground may be exchanged, or handedness is wrong; see docs/conventions.md.",
        "SINGULAR": "Add control off the line or plane of the others, or mend the points named above.",
        "MAX_ITERATIONS": "Check coordinates (B and L exchanged? degrees for metres?), f and the axes of the readings.",
    }.get(found.termination, "Look at the iterations: orient show PROJECT resection")


def _summary(found: Resection, interior: CameraUnknowns | None, sigma0: float) -> str:
    names = () if interior is None else interior.names
    estimated = f", {', '.join(names)} estimated" if names else ""
    if found.redundancy == 0:
        return f"{len(found.iterations)} iterations, no redundancy{estimated}"
    posteriori = (found.vPv / found.redundancy) ** 0.5
    return (
        f"sigma0 {MICROMETRES * posteriori:.3g} um ({posteriori / sigma0:.2f} of a priori), "
        f"r = {found.redundancy}, {len(found.iterations)} iterations{estimated}"
    )
