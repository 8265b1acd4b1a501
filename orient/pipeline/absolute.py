"""Stage `absolute`: seven parameters per zone of the model, and all model points on the ground.

Without any standard deviation, of the model (`sigma_model` or covariances in model.csv) or of the control, every
ground equation weighs the same and sigma0 comes out in metres, as in the papers. Otherwise the given covariances of
both sides are the weights and sigma0 is a number that should be near 1.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from orient.errors import GeometryError
from orient.pipeline.absolute_blunders import Solved, Task, choose_control
from orient.pipeline.absolute_findings import absolute_findings, failure, small_angle_finding
from orient.pipeline.absolute_rows import result_tables, small_angle_rows, trace_tables
from orient.pipeline.absolute_test_rows import test_tables
from orient.pipeline.absolute_zone import Errors, Zone, control_errors, zones_of
from orient.pipeline.exclusions import by_hand_in_parts, numbered, suspicion
from orient.pipeline.frames import Frame, frame_of
from orient.pipeline.ground import ground_of
from orient.pipeline.tables import Array, columns, names, single
from orient.solvers.absolute_orientation import orient_model
from orient.solvers.absolute_result import AbsoluteOrientation
from orient.solvers.absolute_small_angles import orient_by_small_angles
from orient.solvers.consensus import RobustFailed
from orient.solvers.engines import Engine
from orient.units import listed
from orient.values import Event, Outcome, Row, Settings, Tables
from orient.words import counted

HEIGHT_TOLERANCE_M = 1e-3
MAX_HEIGHT_ROUNDS = 10
NAMED = 10
TOLD_ZONES = 3
LARGEST_STORED = 1e15
"""What a project file takes for a number (`models.REAL_LIMIT`)."""
TOO_LARGE = "Take units in which model and ground lie less far apart, and sigmas that are not larger than the model."
Rows = dict[str, list[Row]]


@dataclass(frozen=True, slots=True)
class _Oriented:
    """What came of one zone: rows (iterations only after a failure), remarks, and a line or the reason and remedy."""

    tables: Mapping[str, Sequence[Row]]
    events: Sequence[Event] = ()
    summary: str = ""
    failed: tuple[str, str] | None = None


def compute(inputs: Mapping[str, Tables], settings: Settings) -> Outcome:
    """Outcome with the orientation of every zone; if one zone has none, the whole run failed and says which."""
    ground = ground_of(single(inputs["photo"], "photo"))
    frame = frame_of(single(inputs["topocentric"], "topocentric_frame"), ground)
    zones = zones_of(inputs["model"], inputs["topocentric"], frame, settings)
    by_hand = by_hand_in_parts(settings, {zone.name: zone.control_points for zone in zones}, "control point")
    oriented = [_oriented(zone, by_hand[zone.name], frame, settings) for zone in zones]
    tables: Rows = {}
    for one in oriented:
        _add(tables, one.tables)
    if "exclusion" in tables:
        tables["exclusion"] = numbered(tables["exclusion"])
    events = [*_unused(inputs["topocentric"], zones), *(event for one in oriented for event in one.events)]
    failures = [one.failed for one in oriented if one.failed is not None]
    if failures:
        error = "; ".join(text.rstrip(".") for text, _ in failures)
        return Outcome(_traces_only(tables), events, error=error, hint=failures[0][1])
    events += _disagreements(tables.get("model_ground_point", []))
    return Outcome(tables, events, _together([one.summary for one in oriented]))


def _oriented(zone: Zone, by_hand: Sequence[int], frame: Frame, settings: Settings) -> _Oriented:
    """One zone from its points to its rows."""
    try:
        errors = control_errors(zone, settings)
        task = Task(zone, errors, frame, settings, lambda keep: _solve(zone, errors, keep, frame, settings))
        choice, solved = choose_control(task, by_hand)
    except (GeometryError, RobustFailed) as error:
        return _Oriented({}, failed=(f"zone {zone.name}: {error.message}", error.hint))
    found, control = solved.found, solved.zone
    tables: Rows = {}
    _add(tables, trace_tables(zone, found, frame))
    tested, remarks = test_tables(task, choice, by_hand)
    events = [*absolute_findings(control, found, frame, errors), *remarks]
    if (failed := failure(control, found, frame)) is not None:
        _add(tables, {"exclusion": tested["exclusion"]})
        return _Oriented(tables, events, failed=(failed[0], suspicion(tested["exclusion"]) or failed[1]))
    use_posteriori = settings["variance"] == "posteriori" and found.redundancy > 0
    _add(tables, result_tables(control, found, frame, errors, use_posteriori))
    _add(tables, tested)
    if settings["small_angles"]:
        rows, event = _small_angles(solved, frame, Engine(str(settings["engine"])))
        _add(tables, {"absolute_small_angle": rows})
        events.append(event)
    if (largest := _largest(tables)) > LARGEST_STORED:
        return _Oriented(
            {}, events, failed=(f"zone {zone.name}: numbers up to {largest:.1g} cannot be kept", TOO_LARGE)
        )
    return _Oriented(tables, events, _summary(control, found, errors))


def _add(tables: Rows, more: Mapping[str, Sequence[Row]]) -> None:
    for table, rows in more.items():
        if rows:
            tables.setdefault(table, []).extend(rows)


def _largest(tables: Mapping[str, Sequence[Row]]) -> float:
    numbers = (value for rows in tables.values() for row in rows for value in row.values())
    return max((abs(value) for value in numbers if isinstance(value, float)), default=0.0)


def _traces_only(tables: Rows) -> Rows:
    """Iterations and suspects are stored for a failure too; results of the other zones are not."""
    return {name: rows for name, rows in tables.items() if name.startswith("absolute_iteration") or name == "exclusion"}


def _solve(zone: Zone, errors: Errors, keep: Sequence[int], frame: Frame, settings: Settings) -> Solved:
    """The orientation on some of the control; height-only points are set on the curved surface of their height."""
    zone, errors = zone.of_control(keep), errors.at(keep)
    for _ in range(MAX_HEIGHT_ROUNDS):
        found = orient_model(
            zone.control_model,
            frame.right_handed(zone.control_ground),
            known=frame.right_handed_matrix(zone.control_known),
            ground_cofactor=frame.right_handed_matrix(errors.ground),
            model_cofactor=errors.model,
            names=zone.control_points,
            allow_upside_down=bool(settings["upside_down"]),
            engine=Engine(str(settings["engine"])),
            tolerance=float(settings["tolerance"] or 0.0),
            max_iterations=int(settings["max_iterations"] or 0),
        )
        if frame.origin is None or not found.is_result or not zone.has_height_only:
            return Solved(found, zone, errors)
        computed = frame.right_handed(zone.control_model @ found.rotation.T / found.H + found.X0)
        zone, lift = zone.on_their_height(computed, frame)
        if lift < HEIGHT_TOLERANCE_M:
            break
    return Solved(found, zone, errors)


def _small_angles(solved: Solved, frame: Frame, engine: Engine) -> tuple[Sequence[Row], Event]:
    """(111) beside the rigorous elements: rows, and how far it is off; it can be undetermined where they are not."""
    control, found, errors = solved.zone, solved.found, solved.errors
    try:
        small = orient_by_small_angles(
            found,
            control.control_model,
            frame.right_handed(control.control_ground),
            known=frame.right_handed_matrix(control.control_known),
            ground_cofactor=frame.right_handed_matrix(errors.ground),
            model_cofactor=errors.model,
            engine=engine,
        )
    except GeometryError as error:
        message = f"zone {control.name}: {error.message}"
        return (), Event("warning", "small_angles", control.name, message)
    return small_angle_rows(control, small, frame), small_angle_finding(control, small)


def _unused(topocentric: Tables, zones: Sequence[Zone]) -> list[Event]:
    """Control points that no zone of the model holds."""
    in_model = {point for zone in zones for point in zone.points}
    alone = [point for point in names(topocentric["topocentric_point"]) if point not in in_model]
    if not alone:
        return []
    told = listed(alone)
    many = counted(len(alone), "point has ground coordinates but is", "points have ground coordinates but are")
    message = f"{many} not in the model, not used: {told}"
    return [Event("warning", "not_in_model", told, message, float(len(alone)))]


def _disagreements(rows: Sequence[Row]) -> list[Event]:
    """The largest distance between two zones' positions of a common point."""
    by_point: dict[str, list[Row]] = {}
    for row in rows:
        by_point.setdefault(str(row["point"]), []).append(row)
    common = {point: _spread(columns(same, "X_m", "Y_m", "Z_m")) for point, same in by_point.items() if len(same) > 1}
    if not common:
        return []
    worst = max(common, key=lambda point: common[point])
    many = counted(len(common), "point lies", "points lie")
    message = f"{many} in more than one zone; the zones differ by up to {common[worst]:.3g} m ({worst})"
    return [Event("info", "zones_differ", worst, message, common[worst])]


def _spread(places: Array) -> float:
    return float(np.max(np.linalg.norm(places[:, None] - places[None], axis=2)))


def _together(summaries: Sequence[str]) -> str:
    told = "; ".join(summaries[:TOLD_ZONES])
    return told + (f"; and {counted(len(summaries) - TOLD_ZONES, 'more zone')}" if len(summaries) > TOLD_ZONES else "")


def _summary(zone: Zone, found: AbsoluteOrientation, errors: Errors) -> str:
    head = f"zone {zone.name}: {zone.counts}, t = {found.t:.6g}"
    count = len(zone.excluded)
    left_out = f", {counted(count, 'point')} excluded" if count else ""
    if found.sigma0 is None:
        return f"{head}, no redundancy{left_out}"
    return f"{head}, sigma0 {found.sigma0:.3g}{errors.unit_text}, r = {found.redundancy}{left_out}"
