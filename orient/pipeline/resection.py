"""Stage `resection`: the exterior orientation of the photo by functional iteration, without start values."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from orient.errors import GeometryError
from orient.pipeline.camera import camera_unknowns, with_element
from orient.pipeline.camera_rows import camera_events, camera_tables
from orient.pipeline.chain import Chain
from orient.pipeline.common_coefficients import CommonCoefficients, common_coefficients, sheet_errors
from orient.pipeline.error_sources import ray_cofactor_rows, source_cofactor_rows
from orient.pipeline.exclusions import by_hand, suspicion
from orient.pipeline.findings import in_stored_names, resection_findings
from orient.pipeline.frames import Frame, frame_of
from orient.pipeline.ground import Ground, ground_of
from orient.pipeline.interior_unknowns import adjusted_interior_rows, image_shift, interior_unknowns
from orient.pipeline.known_elements import KnownElements, known_elements, known_events, known_residual_rows
from orient.pipeline.observations import Observations, observations, on_their_height
from orient.pipeline.resection_blunders import Chosen, Solved, Task, choose_control
from orient.pipeline.resection_control import check_line, without_far_points
from orient.pipeline.resection_rows import result_tables
from orient.pipeline.resection_starts import start_tables
from orient.pipeline.resection_test_rows import test_tables
from orient.pipeline.resection_trace import adjusted_coefficient_rows, trace_tables
from orient.pipeline.resection_verdict import Scene, verdict
from orient.pipeline.tables import Array, columns, required, single
from orient.pipeline.weights import ground_weights
from orient.solvers.camera_unknowns import CameraUnknowns
from orient.solvers.engines import Engine
from orient.solvers.resection import Resection, resect
from orient.solvers.resection_problem import ELEMENTS
from orient.units import RADIANS_PER_DEGREE
from orient.values import Event, Outcome, Row, Settings, Tables
from orient.words import counted

if TYPE_CHECKING:
    from orient.pipeline.calibration import Calibration

MINIMUM_POINTS = 3
HEIGHT_TOLERANCE_M = 1e-3
MAX_HEIGHT_ROUNDS = 10
MICROMETRES = 1000.0
FITS = 4.0
"""v'Pv in units of its expectation, below which no other orientation is looked for when some points are left out."""


@dataclass(frozen=True, slots=True)
class Assignment:
    """Everything of a photo that its resections share, whichever points and elements of the camera take part."""

    photo: Row
    photo_tables: Tables
    ground: Ground
    frame: Frame
    control: Observations
    known: KnownElements
    sigma0: float
    settings: Settings


def compute(inputs: Mapping[str, Tables], settings: Settings) -> Outcome:
    """Outcome with orientation, cofactors, iterations, equations and residuals."""
    work, check, events = _assignment(inputs, settings)
    chain = chain_of(work.control, inputs, work.frame, work.ground, work.sigma0, settings)
    task, chosen, calibration = _chosen(work, chain)
    control, found, chain = chosen.solved.control, chosen.solved.found, chosen.solved.chain
    frame, sigma0 = work.frame, work.sigma0
    full = np.flatnonzero(control.known == "XYZ").tolist()
    traces: Tables = {
        **trace_tables(found, frame, control.points, chain.camera, chain.unknowns),
        **start_tables(found, frame, control.points, full, control.ground),
        **({} if calibration is None else {"calibration_step": calibration.rows}),
    }
    events += [] if calibration is None else calibration.events
    judged = verdict(found, _scene(work, chosen.solved, full))
    findings = resection_findings(found, frame, control.points, sigma0) if found.termination == "CONVERGED" else []
    # that it is ambiguous is then the refusal itself
    events += [*judged.events, *(event for event in findings if not judged.error or event.code != "ambiguous")]
    tested, remarks = test_tables(task, chosen)
    if judged.error:
        suspected = {"exclusion": tested["exclusion"]}
        hint = suspicion(tested["exclusion"]) or judged.hint
        return Outcome({**traces, **suspected}, [*events, *remarks], error=judged.error, hint=hint)
    results, told = _results(work, inputs, chosen, check)
    return Outcome({**results, **tested, **traces}, [*events, *remarks, *told], _summary(found, sigma0, chosen))


def adjusted_again(inputs: Mapping[str, Tables], settings: Settings) -> tuple[Solved, Frame]:
    """The adjustment itself with everything that went into it, for who explains or checks it; nothing is judged."""
    work, _, _ = _assignment(inputs, settings)
    chain = chain_of(work.control, inputs, work.frame, work.ground, work.sigma0, settings)
    return _chosen(work, chain)[1].solved, work.frame


def _results(
    work: Assignment, inputs: Mapping[str, Tables], chosen: Chosen, check: Observations
) -> tuple[Tables, list[Event]]:
    """The tables of an adjustment that is a result but its tests, and what they tell."""
    found, control, frame, sigma0 = chosen.solved.found, chosen.solved.control, work.frame, work.sigma0
    use_posteriori = work.settings["variance"] == "posteriori" and found.redundancy > 0
    chain = replace(chosen.solved.chain, sheets=sheet_errors(control.rows, inputs.get("digitize", {}), frame))
    k, elements = chain.interior_unknowns, len(found.unknowns)
    cofactors = np.diagonal(found.joint_cofactors)[elements:]
    in_photo = adjusted_interior_rows(chain.interior, found.common[:k], cofactors[:k], sigma0)
    others = [_moved(points, chain, in_photo) for points in (check, work.control.at(chosen.outside))]
    results = result_tables(found, frame, control, others, sigma0, use_posteriori, chain.camera)
    shares = found.known_redundancy[len(found.known_redundancy) - len(work.known.observations) :]
    known = known_residual_rows(work.known, found.rotation, found.station, shares)
    rename = partial(in_stored_names, frame=frame)
    events = camera_events(found, chain.camera, work.photo, sigma0, use_posteriori, rename)
    tables: dict[str, Sequence[Row]] = {
        **results,
        **camera_tables(found, chain.camera, sigma0, use_posteriori),
        "known_residual": known,
        "cofactor": [*results["cofactor"], *ray_cofactor_rows(found, chain, frame)],
        "adjusted_coefficient": adjusted_coefficient_rows(found.common[k:], cofactors[k:], chain.shared, sigma0),
        "adjusted_interior": in_photo,
        "source_cofactor": source_cofactor_rows(found, chain, frame),
    }
    return tables, [*events, *known_events(known)]


def _assignment(inputs: Mapping[str, Tables], settings: Settings) -> tuple[Assignment, Observations, list[Event]]:
    """The control with all that is known of ground and station; the check points; what could not be used."""
    photo = single(inputs["photo"], "photo")
    ground = ground_of(photo)
    frame = frame_of(single(inputs["topocentric"], "topocentric_frame"), ground)
    seen, events = observations(inputs["refine"], inputs["topocentric"])
    control, check = seen.only("control"), seen.only("check")
    near, far = without_far_points(control.ground, control.known == "XYZ", control.points, str(photo["platform"]))
    control = control.at(near)
    _require_enough(control)
    check_line(control.ground[control.known == "XYZ"])
    sigma0 = required(photo, "sigma_image_mm")
    known = known_elements(inputs["photo"].get("known_element", ()), frame, sigma0)
    work = Assignment(photo, inputs["photo"], ground, frame, control, known, sigma0, settings)
    return work, check, [*events, *far]


def _chosen(work: Assignment, chain: Chain) -> tuple[Task, Chosen, "Calibration | None"]:
    """The points that carry the resection; with --calibrate auto also the elements of the camera that it needs.

    The steps see all points but those excluded by hand; where points were left out, they are taken once more without
    them, and the points are chosen again if that changes the elements.
    """
    if work.settings["calibrate"] != "auto" or chain.camera is None:
        task = _task(work, chain)
        return task, choose_control(task), None
    outside = by_hand(work.settings, work.control.points, "control point")
    inside = [i for i in range(len(work.control.points)) if i not in set(outside)]
    calibration, chosen_chain = _calibrated(work, chain, inside)
    task = _task(work, chosen_chain)
    chosen = choose_control(task)
    if chosen.outside == sorted(outside) or calibration is None:
        return task, chosen, calibration
    again, other_chain = _calibrated(work, chain, chosen.inside)
    if again is None or chosen_chain.camera is None or again.unknowns.names == chosen_chain.camera.names:
        return task, chosen, again or calibration
    task = _task(work, other_chain)
    return task, choose_control(task), again


def _task(work: Assignment, chain: Chain) -> Task:
    """The adjustment of any of the points."""
    known, camera = work.known, chain.camera

    def adjust(keep: Sequence[int], near: Solved | None) -> Solved:
        control, part = work.control.at(keep), chain.at(keep)
        if near is not None and len(near.found.ends) == 1:
            solved = _solve(work, control, part, (near.found.rotation, near.found.station))
            noise = work.sigma0**2 * solved.found.redundancy
            if solved.found.termination == "CONVERGED" and solved.found.vPv < FITS * noise:
                return solved
        return _solve(work, control, part)

    of_camera = 0 if camera is None else len(camera.names) - len(camera.observed)
    of_station = len(known.observations) + (0 if known.fixed_station is None else 3)
    return Task(
        frame=work.frame,
        control=work.control,
        chain=chain,
        f_mm=required(work.photo, "f_mm"),
        settings=work.settings,
        adjust=adjust,
        unknowns=max(len(ELEMENTS) - of_station, 1) + of_camera,
    )


def _calibrated(work: Assignment, chain: Chain, inside: Sequence[int]) -> tuple["Calibration | None", Chain]:
    """The steps of --calibrate auto with some of the points, and the chain with the elements that they take."""
    from orient.pipeline.calibration import calibrate, candidates_of

    control, part = work.control.at(inside), chain.at(inside)
    first = _solve(work, control, part).found
    if chain.camera is None or part.camera is None or first.termination != "CONVERGED":
        return None, chain

    def solve(interior: CameraUnknowns, start: tuple[Array, Array] | None) -> Resection:
        return _solve(work, control, replace(part, camera=interior), start).found

    def add(interior: CameraUnknowns, name: str) -> CameraUnknowns:
        return with_element(interior, name, work.photo, work.photo_tables, work.sigma0)

    rename = partial(in_stored_names, frame=work.frame)
    found = calibrate(part.camera, first, solve, add, candidates_of(part.camera), work.sigma0, rename)
    camera = chain.camera
    for name in found.unknowns.names:
        camera = camera if name in camera.names else add(camera, name)
    return found, replace(chain, camera=camera)


def _moved(points: Observations, chain: Chain, in_photo: Sequence[Row]) -> Observations:
    """Points that took no part, through the adjusted interior orientation."""
    return replace(points, image=points.image + image_shift(chain.interior, in_photo, points.comparator))


def chain_of(
    control: Observations, inputs: Mapping[str, Tables], frame: Frame, ground: Ground, sigma0: float, settings: Settings
) -> Chain:
    """Everything behind the coordinates of the control points that a setting does not take as known."""
    photo = single(inputs["photo"], "photo")
    return Chain(
        interior=None if settings["interior"] == "fixed" else interior_unknowns(inputs["refine"]),
        shared=_shared(control, inputs.get("digitize", {}), frame, ground, settings),
        sheets=(),
        sigma0=sigma0,
        camera=camera_unknowns(photo, inputs["photo"], control.image_rows, settings, sigma0),
    )


def _shared(
    control: Observations, digitize: Tables, frame: Frame, ground: Ground, settings: Settings
) -> CommonCoefficients | None:
    """What control points of one sheet share; nothing without errors, or when each point is to stand apart."""
    if settings["control"] == "fixed" or settings["correlation"] == "point":
        return None
    return common_coefficients(control.rows, digitize, frame, ground)


def _require_enough(control: Observations) -> None:
    full = [name for name, known in zip(control.points, control.known, strict=True) if known == "XYZ"]
    if len(full) < MINIMUM_POINTS:
        listed = f" ({', '.join(full)})" if full else ""
        raise GeometryError(
            f"{counted(len(full), 'control point')} with all three coordinates in the photo{listed}; "
            f"at least {MINIMUM_POINTS} are needed (2 values each, 6 unknowns)",
            "Measure more control points, or give the missing coordinates.",
        )


def _solve(work: Assignment, control: Observations, chain: Chain, start: tuple[Array, Array] | None = None) -> Solved:
    """Resection; height-only points are set on the curved surface of their height again until they lie on it."""
    frame, sigma0, settings = work.frame, work.sigma0, work.settings
    own = None if chain.shared is None else chain.shared.own
    weights = ground_weights(control.rows, str(settings["control"]), sigma0, own)
    place, up = control.ground, control.up
    height_only = control.known == "height"
    for _ in range(MAX_HEIGHT_ROUNDS):
        free, weight = weights.at(up)
        found = resect(
            control.image,
            control.image_covariance / sigma0**2,
            frame.right_handed(place),
            required(work.photo, "f_mm"),
            ground_free=frame.right_handed_matrix(free) if free.any() else None,
            ground_weight=frame.right_handed_matrix(weight) if free.any() else None,
            common=chain.in_solver(control.comparator, frame),
            start_mask=control.known == "XYZ",
            approximate_station=_approximate_station(work.photo, frame, work.ground),
            fixed_station=work.known.fixed_station,
            observed=work.known.observations,
            interior=chain.camera,
            start=start,
            tolerance=float(settings["tolerance"] or 0.0),
            max_iterations=int(settings["max_iterations"] or 0),
            names=control.points,
            engine=Engine(str(settings["engine"])),
            camera_above=_camera_above(work.photo),
            sigma0_mm=sigma0,
        )
        solved = Solved(found, control, chain, place, up, free, weight)
        if not height_only.any() or found.termination != "CONVERGED" or frame.origin is None:
            return solved
        moved, up = on_their_height(control, place, frame.right_handed(found.ground), frame)
        lift = float(np.linalg.norm(moved - place, axis=1).max())
        place = moved
        if lift < HEIGHT_TOLERANCE_M:
            return solved
    return solved


def _scene(work: Assignment, solved: Solved, full: list[int]) -> Scene:
    """The full control points, as the verdict wants them."""
    control, camera, station = solved.control.at(full), solved.chain.camera, work.known.fixed_station
    return Scene(
        points=control.points,
        image=control.image,
        image_cofactor=control.image_covariance / work.sigma0**2,
        ground=work.frame.right_handed(control.ground),
        sigma0_mm=work.sigma0,
        near=_approximate_station(work.photo, work.frame, work.ground) if station is None else station,
        camera_above=_camera_above(work.photo),
        frame=work.frame,
        camera=None if camera is None else camera.of(full),
        is_place_known=station is not None or len(work.known.observations) > 0,
    )


def _camera_above(photo: Row) -> Array | None:
    return None if photo["platform"] == "terrestrial" else np.array([0.0, 0.0, 1.0])


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


def _summary(found: Resection, sigma0: float, chosen: Chosen) -> str:
    count, camera = len(chosen.outside), chosen.solved.chain.camera
    names = () if camera is None else camera.names
    estimated = f", {', '.join(names)} estimated" if names else ""
    left_out = f", {counted(count, 'point')} excluded" if count else ""
    return _fit_in_words(found, sigma0) + estimated + left_out


def _fit_in_words(found: Resection, sigma0: float) -> str:
    if found.redundancy == 0:
        return f"{counted(len(found.iterations), 'iteration')}, no redundancy"
    posteriori = (found.vPv / found.redundancy) ** 0.5
    return (
        f"sigma0 {MICROMETRES * posteriori:.3g} um ({posteriori / sigma0:.2f} of a priori), "
        f"r = {found.redundancy}, {counted(len(found.iterations), 'iteration')}"
    )
